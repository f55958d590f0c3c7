//! Every error that a test allows the device, with its reason.
//!
//! The tests of whole frames, in `tests/`, include this file too.

#![allow(dead_code, unreachable_pub, reason = "each crate that includes this uses its share")]

/// A lens's pixel against f64, in pixels: f32 keeps 24 bits of coordinates up to 4000 pixels
/// (2.4e-4), and the polynomial adds a few roundings.
pub const LENS_PX: f64 = 2e-3;

/// The same for a fisheye: the device's arc tangent is off by more than its rounding.
pub const FISHEYE_PX: f64 = 1e-2;

/// Depth on a triangle or a splat at about 50 m, in metres: positions relative to the eye
/// are good to 4e-6 m, and a plane seen at 80° multiplies that by 6 for each of its terms.
pub const DEPTH_M: f64 = 1e-3;

/// How near to its border, as a share of its radius, a disc may cover a pixel on the device
/// and not in f64, or the reverse: its radius is stored in steps that the reference shares,
/// and what is left is rounding of positions.
pub const DISC_BORDER: f64 = 1e-3;

/// Angle between a unit vector and the one its code gives, radians: half a step of 1/32767 in
/// two coordinates, which the projection from octahedron to sphere stretches by up to 1.7 each.
pub const UNIT_VECTOR_RAD: f64 = 8e-5;

/// Weights, relative: powers and square roots of f32, which WGSL lets drift by some ulp.
pub const WEIGHT_RELATIVE: f64 = 1e-5;

/// The same where a weight is next to nothing: a cosine near 0 carries the rounding of its own
/// computation, 1e-7, four times.
pub const WEIGHT_ABSOLUTE: f64 = 1e-9;

/// What the expectation that gains are 1 takes from the logarithms of known ones: a percent or two
/// for exposures and some more for tints, of the 0.6 that the test's differ by.
pub const GAIN_SHRINKAGE: f64 = 0.02;

/// By how much brightness may differ between parts of a picture whose photographs were exposed up
/// to 1.8 times longer than each other, as a share: the shrinkage above, and patches of a footprint's
/// width that do not lie in each photograph exactly alike.
pub const EXPOSED_ALIKE: f64 = 0.05;

/// The greatest weight that a rig can have, relative: the device takes a thousandth more, so that rounding
/// leaves nobody out, and the reach of its cameras is rounded up.
pub const AT_MOST_RELATIVE: f64 = 2e-3;

/// By how much a share that begins to be heard, twice as fast as its weight grows, may change where that
/// changes by half of a hundred-thousandth.
pub const HEARD_STEP: f64 = 1.1e-5;

/// A depth test is compared only where it is decided by more than this share of the depth.
pub const DEPTH_TEST_RELATIVE: f64 = 1e-5;

/// Colour of a resampled photograph against the painted truth, in 255ths, away from edges: the
/// photograph is bilinear between texels two pixels wide on waves of about a metre, and two
/// bytes are rounded.
pub const RESAMPLED_255: f64 = 6.0;

/// Share of pixels that may exceed it: where the shadow of a pole as a photograph sees it
/// ends on a wall, one of the photograph's pixels mixes pole and wall, and no edge of the view
/// lies there that the comparison could leave out.
pub const RESAMPLED_WRONG_SHARE: f64 = 2e-3;

/// Mean of the same difference.
pub const RESAMPLED_MEAN_255: f64 = 1.0;

/// Colour of a photograph seen from its own centre, mean in 255ths: the projection falls
/// back on the texel's centre, where filtering, the sRGB curve and its inverse round once.
pub const OWN_PHOTOGRAPH_MEAN_255: f64 = 0.5;

/// Colour of the same scene at another place in the world, in 255ths, for 99.9 % of pixels:
/// differences of f64 positions are rounded to f32 at other bits, so that colours may round
/// to the next byte and edges may fall to the other side of a pixel centre.
pub const FAR_AWAY_255: f64 = 1.0;

/// Share of the pixels away from edges whose channels, as bytes, are at most one from the whole
/// frame's reference: software devices decode sRGB by a polynomial that is off by up to a third
/// of a byte and weigh texels in 256ths, and the sum is rounded. Where a depth test is decided by
/// less than the rounding of its depths, a photograph more or less has a say.
pub const FRAME_ALIKE_SHARE: f64 = 0.999;

/// The same difference, for 99 % of the pixels, where coarser levels of the photographs are
/// looked up: those were decoded and encoded once more each, which moves more than one in a thousand
/// by a second byte. The views that need it are compared with coarse photographs as well, of which the
/// full level is looked up, by [`FRAME_ALIKE_SHARE`].
pub const FRAME_MINIFIED_255: f64 = 2.0;

/// Where a homography finds a pixel of the photograph, against where projection does, in pixels:
/// well below what filtering between texels can show. f32 keeps 1e-3 pixels, and a plane seen at
/// 84° multiplies that by ten.
pub const HOMOGRAPHY_PX: f64 = 0.01;

/// Colour of a pixel that is textured by a homography, or between corners, against that of the
/// projected position, in 255ths.
pub const TEXTURING_255: f64 = 1.0;

/// Share of pixels that may exceed it: where the depth test is decided by rounding.
pub const TEXTURING_WRONG_SHARE: f64 = 1e-3;

/// How much the colour of a place may change, in 255ths, while the eye moves by a centimetre or
/// turns by two degrees: two frames are rounded to bytes, which is one, and resampled between
/// other pixels, where a photograph fades or a disc ends.
pub const STEP_255: f64 = 2.0;

/// The same for a step of a centimetre where neighbouring photographs differ by 30 % in exposure,
/// 75 bytes. A share s = 1 / (1 + (3 m / d)²) of another photograph changes by at most 0.7 / 3 m,
/// with d the eye's distance from the nearer of two that are 3 m apart, which is half a byte a
/// centimetre; three rigs, 1.5 m apart, make up to twice that.
pub const EXPOSED_STEP_255: f64 = 2.5;

/// The same with exposure gains, which are solved again as rigs come and go: a photograph goes
/// 15 % of the way to its new gain each frame, of differences of up to 15 bytes.
pub const GAINS_STEP_255: f64 = 4.5;

/// By how much the mean of a picture may change from a frame to the next while gains settle, in 255ths:
/// 15 % of what is left each time, where a photograph that is darker by a factor of 0.6 moves the mean
/// by some bytes.
pub const SETTLING_MEAN_255: f64 = 1.0;

/// Places within 10 m of the eye, metres, wherever in the world: positions relative to the eye are
/// good to 1e-6 m, and the street is far enough from grazing to multiply that by less than 10. A
/// pixel of a large picture is a hundred times as wide there.
pub const JITTER_M: f64 = 1e-5;

/// A step of alignment against f64, in cells: the determinant of a matrix of two gradients that
/// are nearly parallel keeps four digits beside the constant of noise.
pub const ALIGNMENT_CELLS: f64 = 1e-3;

/// A displacement of up to a cell that one step finds, cells: the matrix has noise added to it, which
/// shortens steps by some hundredths, and the patterns are not linear.
pub const FOUND_CELLS: f64 = 0.1;

/// The step that is taken where there is but noise, cells.
pub const STILL_CELLS: f64 = 0.01;

/// By how much the share in which displacements are applied may change while the distance of a rig
/// does by 2 mm: it goes from 0 to 1 over 75 cm, smoothly, by at most 2 a metre, which is 0.004.
pub const SHARE_STEP: f64 = 0.01;

/// Diffused inverse range against f64, relative: nine levels up and down, each a mean and a
/// division, which WGSL lets be off by 2.5 ulp of 6e-8.
pub const DIFFUSION_RELATIVE: f64 = 4e-6;

/// A channel of a completed colour, linear, 0 to 1, against f64: floats of 11 bits, cut off rather
/// than rounded by software devices, at each of nine levels up and down.
pub const COMPLETED: f64 = 3e-3;

/// Which hypothesis is chosen against f64, in hypotheses, where none other is as good: costs of
/// about 0.1 are rounded by 1e-8, and a parabola that bends by 1e-3 makes a few of those 1e-4.
pub const CHOICE_INDEX: f64 = 1e-4;

/// By how much the lowest of some costs must be below the next for the choice between them to be
/// compared: costs of about 0.1 are rounded by 1e-8, and what a choice kept takes off them alike.
pub const DECIDED_COST: f64 = 1e-6;

/// How much a parabola through costs must bend for its lowest point to be compared, see
/// [`CHOICE_INDEX`].
pub const CURVED_COST: f64 = 1e-3;

/// The inverse range that settles against f64, relative: a quotient and a mix.
pub const SETTLED_RELATIVE: f64 = 2e-6;

/// How much a pixel that is inferred may change, in 255ths, while the eye moves by a centimetre: a
/// wall 7 m off moves by a third of a pixel, over which its paint changes by two or three, and two
/// frames are rounded to bytes.
pub const INFERRED_STEP_255: f64 = 4.0;

/// Share of the inferred pixels that may exceed it: three cells, of 16 pixels each, of depths
/// that change their minds. Depths drawn by lot make 4 %.
pub const INFERRED_JUMPING_SHARE: f64 = 1e-3;

/// What photographs disagree on, at most 0.12, and its means over a window, against f64: sums of
/// eleven such values, twice, where the targets hold f32.
pub const COST: f64 = 1e-6;

/// How far a box may miss a photograph's pyramid, metres at the depth 1, where it may be listed all the
/// same: the margins for rounding are a millimetre, half of one at the 2 m from where the test's
/// places begin, and a hundredth of a pixel.
pub const PYRAMID: f64 = 2e-3;

/// By how much more tiles may be listed for photographs than they see something of, as a share:
/// the box around the places of a tile holds more than these, most where depths jump.
pub const TILES_IN_VAIN: f64 = 0.05;

/// The logarithm of an exposure gain against f64: one byte of sRGB is 1.7 % of a linear colour in
/// the middle of its curve, so that a third of one makes 0.6 % of each of the two colours whose
/// ratio it is.
pub const GAIN_LOGARITHM: f64 = 1e-2;

/// A colour that is decoded, and encoded again in f64, in bytes of sRGB: the polynomial is off by up to
/// 0.0125, and f32 by less than a hundredth of that.
pub const DECODED_255: f64 = 0.013;

/// A texel of a level of detail as a byte of sRGB, for each time that it was halved: the four that
/// it is the mean of are decoded, and the mean is rounded to a byte.
pub const HALVED_255: f64 = 1.0;

/// A mask of a level of detail in 255ths, for each time that it was halved: a half may be rounded
/// up or down.
pub const HALVED_MASK_255: f64 = 1.0;

/// The logarithm of a ratio of two colours against f64: two logarithms in f32, of about 4 at most.
pub const OVERLAP_LOGARITHM: f64 = 1e-6;

/// Solved logarithms of gains against f64, where a direct solution and one that is approached
/// until it stands still to 1e-12 differ by what was left to approach.
pub const SOLVED_LOGARITHM: f64 = 1e-8;

/// A displacement between two photographs against f64, of the same brightnesses, pixels: sums of 49
/// products in f32 are good to 1e-6 of themselves, and so are steps of up to a cell of 8 pixels.
pub const ALIGNED_PX: f64 = 1e-4;

/// The same where each looks the photographs up by itself, for [`ALIGNED_SHARE`] of the cells:
/// brightnesses that are off by [`SIGHT_BRIGHTNESS`] are a twentieth of what patterns differ by, and
/// displacements of 3 pixels follow.
pub const ALIGNED_APART_PX: f64 = 0.15;

/// The other cells lie beside one that only one of the two decides to be seen.
pub const ALIGNED_SHARE: f64 = 0.99;

/// How bright a photograph shows a cell, square root of linear, against f64: the cell is looked up
/// three levels down, see [`HALVED_255`], and a byte is 0.004 of a middle grey.
pub const SIGHT_BRIGHTNESS: f64 = 0.01;

/// Share of the cells that must be so: whether one is seen is decided, where a surface ends, by the
/// rounding of its depth.
pub const SIGHT_SHARE: f64 = 0.999;

/// Where a homography in f64 finds a place, against projection in f64, in pixels: Lambert-93
/// coordinates are rounded by 1e-9 m, which is 1e-6 pixels at a metre, and a plane seen at 84°
/// multiplies that by ten.
pub const REFERENCE_PX: f64 = 1e-5;

/// The same along the axis of a view or a photograph, metres.
pub const REFERENCE_M: f64 = 1e-8;

/// The column in which a photograph is made to see the eye, pixels: a product of focal lengths of a
/// thousand pixels and metres, in f64, with angles that were turned there and back.
pub const EPIPOLE_PX: f64 = 1e-6;

/// A homography in f64 against the rotation that it is without a baseline, in its elements: of up to
/// a thousand pixels times a depth of tens of metres, which f64 holds to 1e-11.
pub const HOMOGRAPHY_F64: f64 = 1e-6;

/// The determinant of a homography that is singular, in f64, of what its columns' lengths make.
pub const SINGULAR: f64 = 1e-9;

/// A channel of an enlarged picture against the slope that it samples, in 255ths: it is rounded to a
/// byte, and its weights are f32.
pub const ENLARGED_255: f64 = 0.51;

/// Mean difference between a frame that was computed at half its size and enlarged, and the whole one,
/// in 255ths: the paint changes little from a pixel to the next, and is rounded; along edges and the
/// borders of discs, some per cent of the pixels, tens of bytes are mixed.
pub const ENLARGED_MEAN_255: f64 = 2.0;

/// The direction of a cell, unit, against f64: the mean of sixteen directions in f32.
pub const CELL_DIRECTION: f64 = 5e-7;

/// By how much the costs of two hypotheses may differ otherwise than in f64, of the same brightnesses:
/// each is kept in 11 bits after each of three passes, which for 0.12 is 6e-5.
pub const COST_ROUNDING: f64 = 1.8e-4;

/// How far away an inferred pixel is against f64, of the same cells, relative: a mean of four inverse
/// ranges and a division.
pub const FILLED_RELATIVE: f64 = 1e-6;

/// Share of the inferred pixels, those in doubt and those at the shadows of depths in doubt too, whose
/// colours are at most a 255th from the reference's: photographs agree on doubtful depths as well, or
/// they would not be in doubt.
pub const INFERRED_ALIKE_SHARE: f64 = 0.95;

/// Visibility against f64: of what is undecided a ten-thousandth is left, and f32 keeps 24 bits of it.
pub const VISIBILITY: f64 = 1e-8;

/// Depth in a photograph that a homography gives, relative, where pixels are good to
/// [`HOMOGRAPHY_PX`]: the same terms, over focal lengths of some hundred pixels.
pub const HOMOGRAPHY_DEPTH_RELATIVE: f64 = 1e-4;

/// A byte as a share of one, in 255ths, against f64: f32 rounds it.
pub const BYTE_255: f64 = 1e-4;

/// Share of the pixels that may be off by more than [`RESAMPLED_255`] where a pole is points: they stand
/// for its surface within the radius of a disc, and so does its shadow.
pub const POLE_WRONG_SHARE: f64 = 4e-3;

/// The same in an elevation, which shows on the wall behind a pole of points both borders of the shadows
/// that the pole has in each photograph: a texel of theirs is mixed of pole and wall along each.
pub const ELEVATION_WRONG_SHARE: f64 = 0.02;

/// Steepest change of brightness, as a share, from a pixel to the next at the edge of a feathered mask:
/// photographs are blended over ten pixels and more.
pub const FEATHERED_STEP: f64 = 0.05;

/// The same pictures at other places of a texture, or with other colours where a mask hides them, in
/// 255ths: filtering weighs texels in 256ths, and what is less than that may still round a byte.
pub const FILTERED_255: f64 = 1.0;

/// The same where photographs were halved on the device rather than before they came: means in linear
/// light are rounded to bytes once more, see [`HALVED_255`].
pub const ELSEWHERE_255: f64 = 2.0;

/// Depth as a grey, 10 m / (10 m + depth), in 255ths: half of one is its rounding, and the discs of the
/// pole, 4 m from the eye, lie before its surface by up to 2 cm, which is 0.3 there.
pub const DEPTH_MODE_255: f64 = 1.0;

/// Least share of the pixels that exceed [`RESAMPLED_255`] where photographs do not know of a pole and
/// smear it on the wall behind: it is 30 cm wide, half as far from them as the wall, and two photographs
/// show it there once each.
pub const SMEARED_SHARE: f64 = 0.1;
