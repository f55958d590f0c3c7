//! The homography that a plane induces between two pinholes, in f64.
//!
//! The view takes a place X to `q ~ M (X − C)` and the photograph to `q' ~ M' (X − C')`, where M
//! and M' are 3×3, an intrinsic matrix with last row (0, 0, 1) times a rotation, so that the last
//! component of `M (X − C)` is the depth of X. A pixel `q = (u, v, 1)` sees the places
//!
//! ```text
//! X = C + z M⁻¹ q
//! ```
//!
//! at depth z. Of those, `N · (X − P) = 0` picks the one on the plane through P with normal N:
//!
//! ```text
//! z = N·(P − C) / λ,   λ = N · M⁻¹ q
//! ```
//!
//! With `E' = M' (C − C')` the photograph sees it at
//!
//! ```text
//! p' = M' (X − C') = E' + z M' M⁻¹ q
//! λ p' = E' (Nᵀ M⁻¹ q) + N·(P − C) M' M⁻¹ q = H q
//! H = (N·(P − C) M' + E' Nᵀ) M⁻¹
//! ```
//!
//! So `H q` is p' times λ. Texture coordinates are its first two components divided by the third,
//! and neither the length of N nor its sign has a say. The depth in the photograph, which its
//! depth test needs, does not follow from H q alone: it is the third component divided by λ. So λ
//! is kept as a fourth row, `Nᵀ M⁻¹`, which makes the matrix 4×3. Where `z = N·(P − C) / λ` is not
//! positive, the ray meets the plane behind the eye; where the depth is not, the place is behind
//! the photograph. Signs alone decide neither, because N may have either.
//!
//! The device chooses N so that `N·(P − C) = 1`: then λ is 1/z, one over the depth in the view,
//! and the four rows are p'/z and 1/z, whose signs do decide. A plane that contains C cannot be
//! scaled so; it is seen edge-on and covers no pixel. The device also counts q from a pixel of the
//! sprite, whose column of H is then nearly its direct projection: what is added at other pixels is
//! small, and so is its rounding. It takes M' without intrinsics, as lens distortion comes between
//! those and the pinhole: H gives normalised coordinates, and the lens is applied to them.
//!
//! Hard cases: without baseline E' is 0 and H the rotation `M' M⁻¹`, whatever the plane. Where the
//! photograph's centre lies on the plane, H is singular: the plane is a line in the photograph, on
//! which coordinates are right all the same. As `N·(P − C)` nears 0, H nears `E' Nᵀ M⁻¹`: all
//! pixels see the epipole, and errors of N·(P − C) grow without bound.

use glam::{DMat3, DVec3};

/// A pinhole: `p = m (X - centre)`, homogeneous pixels whose last component is depth in metres.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Pinhole {
    pub(crate) m: DMat3,
    pub(crate) centre: DVec3,
}

/// What a homography says about a pixel.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Found {
    /// Homogeneous pixel of the photograph; its last component is depth, metres.
    pub(crate) place: DVec3,
    /// In the view, metres; not positive behind the eye.
    pub(crate) view_depth: f64,
}

/// H, and the row that gives λ.
pub(crate) fn homography(
    view: &Pinhole,
    photograph: &Pinhole,
    p: DVec3,
    n: DVec3,
) -> (DMat3, DVec3) {
    let e = photograph.m * (view.centre - photograph.centre);
    let outer = DMat3::from_cols(e * n.x, e * n.y, e * n.z);
    let inverse = view.m.inverse();
    let h = (photograph.m * n.dot(p - view.centre) + outer) * inverse;
    (h, inverse.transpose() * n)
}

pub(crate) fn by_homography(
    view: &Pinhole,
    photograph: &Pinhole,
    p: DVec3,
    n: DVec3,
    q: DVec3,
) -> Found {
    let (h, row) = homography(view, photograph, p, n);
    let lambda = row.dot(q);
    Found { place: h * q / lambda, view_depth: n.dot(p - view.centre) / lambda }
}

/// The same, by the place itself.
pub(crate) fn by_projection(
    view: &Pinhole,
    photograph: &Pinhole,
    p: DVec3,
    n: DVec3,
    q: DVec3,
) -> Found {
    let ray = view.m.inverse() * q;
    let view_depth = n.dot(p - view.centre) / n.dot(ray);
    let place = photograph.m * (view.centre + ray * view_depth - photograph.centre);
    Found { place, view_depth }
}
