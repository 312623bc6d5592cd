//! The parameters of a scanned part.

use files::{Field, Group};

/// The scan of the finished part, and what it is judged by.
pub(super) const SCAN: Group = Group {
    section: "Verify",
    name: "Scanned part",
    is_folded: true,
    fields: &[
        Field::file("scan.file", "Scan").help(
            "Points of the finished part, as STL, OBJ, PLY, XYZ or CSV (mm), roughly aligned. They are fitted to the part and \
             their deviations judged.",
        ),
        Field::number("scan.tolerance_mm", "Tolerance", "mm", 1e-4, 10.0)
            .decimals(4)
            .help("Greatest deviation, either way."),
        Field::number("scan.least_share", "Share within", "", 0.0, 1.0)
            .decimals(3)
            .help("Least share of the points that must lie within the tolerance."),
        Field::text("scan.free", "Free axes").help(
            "Axes that the fit may move the scan along and about: letters of x, y, z, a, b, c with commas between, as x,y,z,c \
             for what a machine can correct; none for a scan that lies as it is to be.",
        ),
        Field::number("scan.reach_mm", "Reach", "mm", 1e-3, 1000.0)
            .decimals(2)
            .or_nothing(2.0)
            .help("Distance from the part beyond which points do not count: what the scanner saw of a fixture."),
    ],
};
