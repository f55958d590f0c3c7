// Where the nearest rigs have spoken. Equation in rest/reference.rs.

// Share of what the nearest rigs say that is not heard of others.
const UNHEARD: f32 = 0.03125;

// What is heard of a weighted colour and its weight. said: the weight of the nearest rigs.
fn heard(colour: vec4<f32>, said: f32) -> vec4<f32> {
    let share = 2.0 * (colour.w - UNHEARD * said) / max(colour.w, 1e-30);
    return colour * clamp(share, 0.0, 1.0);
}
