// Sets every word to the largest: no depth, no index. Four at once: software devices write for one
// thread after the other.

@group(0) @binding(0) var<storage, read_write> words: array<vec4<u32>>;

@compute @workgroup_size(256)
fn fill(
    @builtin(global_invocation_id) id: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
) {
    let word = id.y * groups.x * 256u + id.x;
    if word < arrayLength(&words) {
        words[word] = vec4(0xffffffffu);
    }
}
