//! The parameters of blades that a blisk is made from.

use files::{Field, Group, Variant, When, word};

/// Where the blisk comes from.
const KINDS: &[Variant] = &[
    Variant { word: word("none", "mesh", "The mesh of the finished blisk"), new: "{ kind = \"none\" }" },
    Variant {
        word: word("measured", "measured sections", "Blades through measured sections, between two rings"),
        new: "{ kind = \"measured\", file = \"sections.csv\" }",
    },
    Variant {
        word: word("profile", "profile", "Blades of a profile that is given by its angles, radii and thickness"),
        new: "{ kind = \"profile\" }",
    },
];
const MEASURED: When = When::Is("blisk.sections.kind", &["measured"]);
const PROFILE: When = When::Is("blisk.sections.kind", &["profile"]);

/// Blades instead of a mesh.
pub(super) const BLADES: Group = Group {
    section: "Part",
    name: "Blades",
    is_folded: true,
    fields: &[
        Field::variant("blisk.sections", "Blisk from", "kind", KINDS)
            .help("The mesh of the finished blisk, or sections of its blades that a blisk is made from."),
        Field::file("blisk.sections.file", "Sections")
            .when(MEASURED)
            .help(
                "Table of the measured sections in W: columns section, side, x, y, z or x, r, theta_deg; and, if wished, weight, \
                 and tx, ty, tz, the direction at the first and the last point of a side.",
            ),
        Field::number("blisk.sections.limit_mm", "Limit of sections", "mm", 1e-4, 10.0)
            .when(MEASURED)
            .help(
                "Greatest deviation of a measured point that is accepted, from the wall that is planned for and from the wall \
                 through the other sections.",
            ),
        Field::integer("blisk.sections.ring.blades", "Blades", 3.0, 1000.0).when(MEASURED).help("Number of blades."),
        Field::numbers("blisk.sections.ring.faces_x_mm", "Faces", "mm", -1e4, 1e4)
            .count(2)
            .when(MEASURED)
            .help("X of the two faces, that at -X first."),
        Field::numbers("blisk.sections.ring.hub_radius_mm", "Hub radii", "mm", 1.0, 1e4)
            .count(2)
            .when(MEASURED)
            .help("Radius of the hub at each face."),
        Field::numbers("blisk.sections.ring.shroud_radius_mm", "Shroud radii", "mm", 1.0, 1e4)
            .count(2)
            .when(MEASURED)
            .help("Radius of the shroud at each face."),
        Field::number("blisk.sections.ring.bore_radius_mm", "Bore radius", "mm", 0.5, 1e4)
            .when(MEASURED)
            .help("Radius of the bore."),
        Field::number("blisk.sections.ring.outer_radius_mm", "Outer radius", "mm", 1.0, 1e4)
            .when(MEASURED)
            .help("Radius of the outside of the shroud's ring."),
        Field::integer("blisk.sections.blades", "Blades", 3.0, 1000.0).when(PROFILE).help("Number of blades."),
        Field::number("blisk.sections.hub_radius_mm", "Hub radius", "mm", 1.0, 1e4)
            .when(PROFILE)
            .help("Radius of the hub at mid-chord."),
        Field::number("blisk.sections.shroud_radius_mm", "Shroud radius", "mm", 1.0, 1e4)
            .when(PROFILE)
            .help("Radius of the shroud, or of the blade tips, at mid-chord."),
        Field::number("blisk.sections.hub_slope", "Hub slope", "", -1.0, 1.0)
            .when(PROFILE)
            .help("Growth of the hub radius along X."),
        Field::number("blisk.sections.shroud_slope", "Shroud slope", "", -1.0, 1.0)
            .when(PROFILE)
            .help("Growth of the shroud radius along X."),
        Field::number("blisk.sections.bore_radius_mm", "Bore radius", "mm", 0.5, 5000.0)
            .when(PROFILE)
            .help("Radius of the bore."),
        Field::number("blisk.sections.wall_mm", "Outer ring", "mm", 0.5, 500.0)
            .when(PROFILE)
            .help("Least thickness of the ring outside the shroud."),
        Field::number("blisk.sections.width_mm", "Width", "mm", 1.0, 1000.0)
            .when(PROFILE)
            .help("Width of the blisk between its faces."),
        Field::number("blisk.sections.chord_mm", "Chord", "mm", 1.0, 500.0)
            .when(PROFILE)
            .help("Axial chord of the blades at the hub, between the tips of the edges."),
        Field::number("blisk.sections.beta_in_deg", "Inlet angle", "deg", -75.0, 75.0)
            .symbol("β_1")
            .when(PROFILE)
            .help("Blade angle at the leading edge, at mid-span, from the axis."),
        Field::number("blisk.sections.beta_out_deg", "Outlet angle", "deg", -75.0, 75.0)
            .symbol("β_2")
            .when(PROFILE)
            .help("Blade angle at the trailing edge, at mid-span, from the axis."),
        Field::number("blisk.sections.wedge_in_deg", "Leading wedge", "deg", 0.0, 60.0)
            .when(PROFILE)
            .help("Wedge angle of the leading edge."),
        Field::number("blisk.sections.wedge_out_deg", "Trailing wedge", "deg", 0.0, 60.0)
            .when(PROFILE)
            .help("Wedge angle of the trailing edge."),
        Field::number("blisk.sections.max_thickness_mm", "Thickness", "mm", 0.1, 250.0)
            .when(PROFILE)
            .help("Greatest thickness of the blades, at mid-chord, at the hub."),
        Field::number("blisk.sections.leading_radius_mm", "Leading radius", "mm", 0.02, 100.0)
            .when(PROFILE)
            .help("Radius of the leading edge at the hub."),
        Field::number("blisk.sections.trailing_radius_mm", "Trailing radius", "mm", 0.02, 100.0)
            .when(PROFILE)
            .help("Radius of the trailing edge at the hub."),
        Field::number("blisk.sections.twist_deg", "Twist", "deg", -60.0, 60.0)
            .when(PROFILE)
            .help("Growth of both blade angles from the hub to the tip."),
        Field::number("blisk.sections.lean_deg", "Lean", "deg", -45.0, 45.0)
            .when(PROFILE)
            .help("Lean of the stacking line towards greater theta."),
        Field::number("blisk.sections.taper", "Taper", "", -0.5, 0.5)
            .when(PROFILE)
            .help("0 for the same section at tip and hub, 0.2 for a tip smaller by a fifth."),
        Field::flag("blisk.sections.shrouded", "Shroud")
            .when(PROFILE)
            .help("Whether a ring closes the channels outside."),
    ],
};
