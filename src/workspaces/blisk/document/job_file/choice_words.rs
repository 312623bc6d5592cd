//! Words of the parameters of a blisk's plan that are a choice: as they stand in files, and as they are shown.

use files::{Word, word};

pub(super) const UNITS: &[Word] = &[
    word("auto", "automatic", ""),
    word("mm", "mm", ""),
    word("cm", "cm", ""),
    word("m", "m", ""),
    word("inch", "inch", ""),
    word("um", "µm", ""),
];
pub(super) const AXES: &[Word] =
    &[word("auto", "automatic", ""), word("x", "X", ""), word("y", "Y", ""), word("z", "Z", "")];
/// The words of [`AXES`]: otherwise the axis is a line that is given.
pub(super) const AXIS_WORDS: &[&str] = &["auto", "x", "y", "z"];
pub(super) const SIDES: &[Word] = &[
    word("auto", "automatic", ""),
    word("-x", "-X", ""),
    word("+x", "+X", ""),
    word("outward", "rim", ""),
    word("inward", "bore", ""),
];
pub(super) const SIDES_OF_STAGE: &[Word] = &[
    word("", "as all", "The side of entry of all stages"),
    word("auto", "automatic", ""),
    word("-x", "-X", ""),
    word("+x", "+X", ""),
    word("outward", "rim", ""),
    word("inward", "bore", ""),
];
pub(super) const Z_AT: &[Word] =
    &[word("rim", "its rim", ""), word("bore", "its bore", ""), word("middle", "its middle", "")];
pub(super) const END_WALLS: &[Word] = &[word("measured", "surfaces", ""), word("drawn", "drawn curves", "")];
pub(super) const MACHINES: &[Word] =
    &[word("XYZC", "XYZ C", ""), word("XYZAC", "XYZ A C", ""), word("XYZABC", "XYZ A B C", "")];
pub(super) const BODIES: &[Word] = &[
    word("", "none", ""),
    word("xyzc", "built-in XYZ C", ""),
    word("xyzac", "built-in XYZ A C", ""),
    word("xyzabc", "built-in XYZ A B C", ""),
    word("xyzac-ram", "built-in XYZ A C, ram", ""),
];
pub(super) const TURNED: &[Word] = &[word("electrode", "the electrode", ""), word("table", "the table under A", "")];
pub(super) const HEADS: &[Word] = &[word("x", "along X", ""), word("z", "along Z", "")];
pub(super) const FACES: &[Word] = &[word("-x", "at -X", ""), word("+x", "at +X", "")];
pub(super) const CHANNELS: &[Word] = &[word("own", "the planned one", ""), word("all", "all, by A", "")];
pub(super) const CONSTRAINTS: &[Word] = &[word("distance", "distance", ""), word("angle", "angle", "")];
pub(super) const STRATEGIES: &[Word] = &[
    word("global", "global", ""),
    word("genetic", "genetic", ""),
    word("centreline", "centreline", ""),
    word("free-travel", "free travel", ""),
    word("max-min-distance", "max. min. distance", ""),
];
pub(super) const CURVES: &[Word] = &[word("spline", "cubic spline", ""), word("nurbs", "NURBS", "")];
pub(super) const H_MODES: &[Word] = &[word("given", "as given", ""), word("variable", "search", "")];
pub(super) const JOB_SHEETS: &[Word] = &[word(nc::template::STANDARD, "Built-in", "")];
pub(super) const POSTS: &[Word] = &[word("iso", "ISO 6983 (RS-274)", ""), word("beckhoff-edm", "Beckhoff EDM", "")];
pub(super) const FRAMES: &[Word] = &[word("mesh", "loaded mesh", ""), word("w", "workpiece W", "")];
pub(super) const SIZES: &[Word] = &[word("given", "as given", ""), word("auto", "found", "")];
pub(super) const ENDS: &[Word] = &[word("not-a-knot", "not-a-knot", ""), word("natural", "natural", "")];
