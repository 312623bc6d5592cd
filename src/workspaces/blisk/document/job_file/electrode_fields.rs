//! The parameters of single parts of a channel, and of electrodes of one's own.

use files::{Field, Group};

use super::choice_words::{SIDES, SIDES_OF_STAGE};

/// Columns of the table of single parts.
const PART: &[Field] = &[
    Field::choice("enter", "Enter from", SIDES).help("The part's own side of entry; automatic: that of all parts."),
    Field::number("until", "Division", "", 0.01, 0.99).decimals(2).or_nothing(0.5).help(
        "Where the part ends and the next one begins, as a share of the burned length from the first station of the \
         passage.",
    ),
    Field::number("overlap_mm", "Overlap", "mm", 0.0, 100.0)
        .decimals(2)
        .or_nothing(1.0)
        .help("Overlap of the burns of this part and the next."),
    Field::number("low_reduction_deg", "Low wall", "deg", 0.0, 45.0)
        .or_nothing(1.0)
        .help("The part's own reduction at the low wall."),
    Field::number("high_reduction_deg", "High wall", "deg", 0.0, 45.0)
        .or_nothing(1.0)
        .help("The part's own reduction at the high wall."),
    Field::number("radial_reduction_mm", "Radial", "mm", 0.0, 100.0)
        .or_nothing(1.0)
        .help("The part's own radial reduction."),
];

/// Columns of the table of stages.
const STAGE: &[Field] = &[
    Field::text("name", "Name").help("Name of the stage in lists and reports."),
    Field::number("spark_gap_mm", "Spark gap", "mm", 0.005, 2.0).step(0.005).help("Spark gap of its burns."),
    Field::number("stock_mm", "Stock", "mm", 0.0, 2.0).step(0.005).help(
        "Stock left for the later stages on every surface; its electrodes are smaller by that and the spark gap.",
    ),
    Field::integer("parts", "Parts", 1.0, 20.0).or_nothing(1.0).help("The stage's own number of parts."),
    Field::integer("columns", "Columns", 1.0, 2.0).or_nothing(1.0).help("The stage's own number of columns."),
    Field::choice("enter", "Enter from", SIDES_OF_STAGE).help("The stage's own side of entry."),
    Field::rows("part", "Part", PART, "{ enter = \"auto\" }")
        .help("Own values of single parts in this stage; where there are any, those of Single parts do not count."),
    Field::number("low_reduction_deg", "Low wall", "deg", 0.0, 45.0)
        .or_nothing(1.0)
        .help("The stage's own reduction at the low wall."),
    Field::number("high_reduction_deg", "High wall", "deg", 0.0, 45.0)
        .or_nothing(1.0)
        .help("The stage's own reduction at the high wall."),
    Field::number("radial_reduction_mm", "Radial", "mm", 0.0, 100.0)
        .or_nothing(1.0)
        .help("The stage's own radial reduction."),
    Field::text("last_step", "Last step")
        .help("Name of the step of the technology at which its burns end; empty to end at the finish."),
    Field::number("finish_vdi", "Finish", "VDI", -20.0, 60.0)
        .decimals(1)
        .step(0.1)
        .or_nothing(24.0)
        .help("Finish at which its burns end (VDI 3400)."),
];

/// Stages in which the channel is burned.
pub(super) const STAGES: Group = Group {
    section: "Electrode",
    name: "Stages",
    is_folded: true,
    fields: &[Field::rows("electrode.stage", "Stage", STAGE, "{ name = \"finish\", spark_gap_mm = 0.1 }").help(
        "Stages in which the channel is burned, in order, as roughing and finishing: each with electrodes of its own for \
         every part. With stages, the spark gap and the end of burning above do not count. What single parts have of their \
         own holds in every stage that has as many parts and no [[electrode.stage.part]] of its own.",
    )],
};

/// Columns of the table of further electrodes of one's own.
const OWN: &[Field] = &[
    Field::file("mesh", "Mesh").help("Its mesh, in its final pose in the coordinates of the blisk's mesh (mm)."),
    Field::choice("enter", "Enter from", SIDES).help("Its own side of entry; automatic: that of all."),
];

/// What single parts have of their own.
pub(super) const SINGLE_PARTS: Group = Group {
    section: "Electrode",
    name: "Single parts",
    is_folded: true,
    fields: &[Field::rows("electrode.part", "Part", PART, "{ enter = \"auto\" }").help(
        "What single parts have of their own, in order along the passage, that at its first station first. What a \
         row leaves out, and parts without a row, are as set above.",
    )],
};

/// Electrodes of one's own instead of derived ones.
pub(super) const OWN_ELECTRODE: Group = Group {
    section: "Electrode",
    name: "Own electrode",
    is_folded: true,
    fields: &[
        Field::file("electrode.mesh", "Mesh").help(
            "An electrode of your own instead of a derived one, in its final pose in the coordinates of \
             the blisk's mesh (mm).",
        ),
        Field::rows("electrode.more", "Further", OWN, "{ mesh = \"\" }").help(
            "More electrodes of your own for the same channel, in the order in which they burn, as those of the \
             front and the back, or of the left and the right of it.",
        ),
    ],
};
