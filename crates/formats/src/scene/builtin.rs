//! Scenes that come with the program.

/// A scene that comes with the program.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BuiltinScene {
    /// Name on the command line.
    pub name: &'static str,
    /// What it shows, in one line.
    pub summary: &'static str,
    /// The scene file.
    pub toml: &'static str,
}

/// A scene of the workspace's `scenes` folder.
macro_rules! builtin {
    ($name:literal, $summary:literal) => {
        BuiltinScene {
            name: $name,
            summary: $summary,
            toml: include_str!(concat!("../../../../scenes/", $name, ".toml")),
        }
    };
}

const SCENES: [BuiltinScene; 6] = [
    builtin!("snowy-teapot", "Figure 5: a red teapot under thick snow, 1 000 000 grains"),
    builtin!("snowy-teapot-thin", "the same number of smaller grains: a thin cover"),
    builtin!("snowy-sphere-thick", "Figure 4: a red sphere under thick snow, 1 000 000 grains"),
    builtin!("snowy-sphere-thin", "Figure 4: the same number of smaller grains: a thin cover"),
    builtin!("snow-cube", "Figures 1-3: a cube of 1 755 904 grains in the tightest packing"),
    builtin!("snow-cube-sc", "the benchmark: a simple cubic cube of 120 x 120 x 120 grains"),
];

/// All scenes that come with the program.
#[must_use]
pub fn builtin_scenes() -> &'static [BuiltinScene] {
    &SCENES
}

/// The scene called `name`.
#[must_use]
pub fn builtin_scene(name: &str) -> Option<&'static BuiltinScene> {
    SCENES.iter().find(|scene| scene.name == name)
}
