// Needs viewport.wgsl.

@vertex
fn vs(@builtin(vertex_index) index: u32) -> @builtin(position) vec4<f32> {
    return corner_of_viewport(index);
}
