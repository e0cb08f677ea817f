//! Files inside the program: the demo scene and what it uses, so that the binary alone shows a picture.

use std::path::Path;

/// The scene that is shown where none is named. Paths that begin with `glimt:` mean files inside the program; those
/// of the demo scene do by themselves, because they are relative to it.
pub const DEMO: &str = "glimt:/demo.toml";

/// Paths and contents.
const FILES: [(&str, &[u8]); 3] = [
    (DEMO, include_bytes!("../../scenes/demo.toml")),
    ("glimt:/textures/fence.png", include_bytes!("../../scenes/textures/fence.png")),
    ("glimt:/textures/stone.png", include_bytes!("../../scenes/textures/stone.png")),
];

/// The content of a file inside the program; `None` if the path means none.
pub fn builtin(file: &Path) -> Option<&'static [u8]> {
    FILES.iter().find(|(path, _)| file == Path::new(path)).map(|(_, content)| *content)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_file_that_the_demo_scene_names_is_inside_the_program() {
        let demo = std::str::from_utf8(builtin(Path::new(DEMO)).unwrap()).unwrap();
        let named: Vec<_> = demo.split("file = \"").skip(1).filter_map(|rest| rest.split('"').next()).collect();
        assert!(!named.is_empty());
        for file in named {
            assert!(builtin(&Path::new(DEMO).parent().unwrap().join(file)).is_some(), "{file}");
        }
        assert!(builtin(Path::new("demo.toml")).is_none());
    }
}
