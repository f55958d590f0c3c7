// The plane that a point's disc lies on. Equations in splat/reference.rs.

// Cosine between ray and normal below which a disc turns back towards the eye: a plane seen
// edge-on could face either way.
const LEAST_COSINE: f32 = 0.1;

// toward: unit, from the eye to the point; n: normal of the point, of length 1 and of either
// sign, or 0 where it has none. The normal of its disc, of component 1 along `toward`.
fn disc_normal(toward: vec3<f32>, n: vec3<f32>) -> vec3<f32> {
    let cosine = dot(n, toward);
    let fade = cosine / max(cosine * cosine, LEAST_COSINE * LEAST_COSINE);
    return toward + (n - toward * cosine) * fade;
}
