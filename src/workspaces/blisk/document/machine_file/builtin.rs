//! The machines that the program brings along.

/// Names of the built-in machines.
pub const BUILT_IN: [&str; 3] = ["xyzc", "xyzac", "xyzabc"];

/// The file of the built-in machine called `name`.
pub(super) fn text_of(name: &str) -> Option<&'static str> {
    match name {
        "xyzc" => Some(include_str!("../../../../../assets/machines/xyzc.toml")),
        "xyzac" => Some(include_str!("../../../../../assets/machines/xyzac.toml")),
        "xyzabc" => Some(include_str!("../../../../../assets/machines/xyzabc.toml")),
        _ => None,
    }
}
