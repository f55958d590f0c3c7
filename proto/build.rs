//! Compiles the .proto files with protox, so that no protoc is needed.

use std::path::PathBuf;

use prost::Message;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let files = ["geometry", "scene", "footprint", "ground", "panorama", "point", "render"]
        .map(|name| format!("proto/flaneur/v1/{name}.proto"));
    for file in &files {
        println!("cargo::rerun-if-changed={file}");
    }
    let descriptors = protox::compile(&files, ["proto"])?;
    let out = PathBuf::from(std::env::var("OUT_DIR")?);
    std::fs::write(out.join("flaneur.v1.bin"), descriptors.encode_to_vec())?;
    tonic_prost_build::configure().bytes(".flaneur.v1").compile_fds(descriptors)?;
    Ok(())
}
