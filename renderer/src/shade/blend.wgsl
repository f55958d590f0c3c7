// How much a photograph has to say about a place. Equations and reasons in
// shade/reference.rs.

// Metres. Keeps the weight finite where the eye, or the place, is at a photograph's centre.
const NEAREST_M: f32 = 0.05;
// Cosine at which a surface is seen so nearly edge-on that nothing is seen of it.
const SEEN_COSINE: f32 = 0.01;
// Share of the picture's shorter side over which a photograph fades towards its border.
const FEATHER: f32 = 0.05;

// Equation 4 of Park et al. with alpha = 4. Squared distances in metres.
fn park_weight(cosine: f32, place_distance_2: f32, eye_distance_2: f32) -> f32 {
    let c2 = cosine * cosine;
    let nearest_2 = NEAREST_M * NEAREST_M;
    return select(0.0, c2 * c2, cosine > SEEN_COSINE)
        / ((place_distance_2 + nearest_2) * (eye_distance_2 + nearest_2));
}

// border: distance from the picture's border as a share of its shorter side.
fn feather_weight(border: f32) -> f32 {
    return smoothstep(0.0, 1.0, border * (1.0 / FEATHER));
}

// inside: how far inside its mask a photograph shows the place, 0 to 1.
fn mask_weight(inside: f32) -> f32 {
    let fade = smoothstep(0.0, 1.0, inside);
    return fade * fade * fade;
}

// visible: share of the bilinear footprint in the depth map that sees the place.
fn edge_weight(visible: f32) -> f32 {
    return max(2.0 * visible - 1.0, 0.01 * visible);
}

// By what the cameras of one rig are compared, 0 to 1. They nearly share a centre, so that border
// decides, unless the eye is so close that it is in one of them rather than in the others.
fn rig_score(border: f32, closeness: f32) -> f32 {
    return 2.0 * border * closeness;
}
