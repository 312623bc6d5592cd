//! Every parameter of a mold. Forms, `--set`, reports and the names of steps of undo are made from this table.

use super::MoldParams;
use crate::workspaces::setup::SETUP_SHEET_FIELDS;
use crate::workspaces::technology::technology_fields;
use files::{Field, FieldTable, Group, Variant, When, Word, word};
use import::Units;
use mold::cutter::CutterLibrary;
use mold::datum::FURTHEST;
use mold::electrode::params::Edit;

const OPENINGS: &[Word] = &[
    word("auto", "as proposed", "The direction from which most of the part is seen"),
    word("+x", "+x", ""),
    word("-x", "-x", ""),
    word("+y", "+y", ""),
    word("-y", "-y", ""),
    word("+z", "+z", ""),
    word("-z", "-z", ""),
];
const SHAPES: &[Word] = &[
    word("undersized", "undersized", "With spark gap: the electrode as it is milled, smaller by the undersize"),
    word("net", "net", "Without spark gap: the net shape; the undersize is stated in the burn table"),
];
const DIVIDED_AT: &[Word] = &[
    word("h-edges", "H-edges", "Unmillable inner edges: those that no cutter mills"),
    word("every-edge", "every inner edge", "Also inner edges that a flat end mills"),
    word("nothing", "nowhere", "A head for each region"),
];
const REPEAT: &[Word] = &[
    word("burns", "one head", "One head burns one place after another"),
    word("heads", "several heads", "As many heads on one base burn them at once"),
];
const ORBITS: &[Variant] = &[
    Variant { word: word("none", "no orbit", ""), new: "{ pattern = \"none\" }" },
    Variant { word: word("circular", "circle", ""), new: "{ pattern = \"circular\", radius_mm = 0.05 }" },
    Variant { word: word("square", "square", ""), new: "{ pattern = \"square\", radius_mm = 0.05 }" },
];
const STAGE: &[Field] = &[
    Field::text("name", "Name").help("Letters, digits, - and _: part of file names."),
    Field::number("gap_mm", "Spark gap", "mm", 0.0, 5.0).symbol("gap").step(0.005).help("Spark gap of the burn."),
    Field::number("stock_mm", "Stock", "mm", 0.0, 5.0)
        .symbol("stock")
        .step(0.005)
        .help("Stock left for the later stages, on every face."),
    Field::number("finish_vdi", "Finish", "VDI", 0.0, 60.0)
        .decimals(1)
        .step(0.1)
        .symbol("finish")
        .help("Surface finish to be reached (VDI 3400): 20 log Ra is the finish less 20, with Ra in micrometres."),
    Field::text("last_step", "Last step")
        .symbol("last step")
        .help("Name of the step of the technology at which burning ends; empty: at the finish."),
    Field::integer("quantity", "Pieces", 1.0, f64::INFINITY)
        .symbol("pieces")
        .help("How many of each electrode are made."),
    Field::variant("orbit", "Orbit", "pattern", ORBITS)
        .symbol("orbit")
        .help("Orbital motion across the burn direction; the electrode is smaller by it."),
    Field::number("orbit.radius_mm", "Radius of orbit", "mm", 0.0, 5.0)
        .symbol("radius")
        .step(0.005)
        .when(When::IsNot("orbit.pattern", &["none"]))
        .help("Radius of the circle, or half the side of the square."),
];
const HOLDER: &[Field] = &[
    Field::text("name", "Name").help("Name of the holder."),
    Field::numbers("size_mm", "Largest blank", "mm", 1e-3, 1e4).count(2).help("Largest blank that it holds, X and Y."),
    Field::number("height_mm", "Height", "mm", 1e-3, 1e4).help("Height above the blank."),
];
const CUTTER: &[Field] = &[
    Field::text("name", "Name").symbol("name").help("Name in lists; empty to be called after its shape."),
    Field::number("diameter_mm", "Diameter", "mm", 0.01, 500.0)
        .symbol("\u{d8}")
        .step(0.02)
        .help("Diameter of the cutting part."),
    Field::number("corner_mm", "Corner", "mm", 0.0, 250.0)
        .symbol("corner")
        .step(0.02)
        .help("Radius of the rounded edge: 0 for a flat end, half the diameter for a ball, between for a bull-nose."),
    Field::number("reach_mm", "Reach", "mm", 0.01, 5000.0)
        .or_nothing(20.0)
        .symbol("reach")
        .step(0.1)
        .help("Greatest depth below the material that the holder passes over; none for as deep as need be."),
    Field::number("holder_diameter_mm", "Holder", "mm", 0.01, 5000.0)
        .or_nothing(30.0)
        .symbol("\u{d8} holder")
        .step(0.1)
        .when(When::IsNot("reach_mm", &[""]))
        .help("Diameter of the holder, which counts where the reach is limited."),
];
const NEW_CUTTER: &str = "{ diameter_mm = 2.0 }";
const CUTTERS: &str = "The cutters, of which a region is uncut where none reaches. A new one is flat.";

/// The other cutters of the comparison.
pub static LIBRARY: FieldTable<CutterLibrary> = FieldTable::new(&[Group {
    section: "",
    name: "",
    is_folded: false,
    fields: &[Field::rows("cutter", "Other cutters", CUTTER, NEW_CUTTER).help(CUTTERS)],
}]);

/// Every parameter of a mold.
pub static FIELDS: FieldTable<MoldParams> = FieldTable::new(&[
    Group {
        section: "Mold",
        name: "Mold",
        is_folded: false,
        fields: &[
            Field::file("mesh", "Mesh").help("The mold: STL, OBJ, glTF, GLB or STEP."),
            Field::choice("units", "Unit", Units::WORDS).help("Unit of the mesh."),
            Field::numbers("solids", "Solids", "", 1.0, 10_000.0).whole().help(
                "Numbers of the solids of a STEP file that make the mold. None for the largest that is no obstacle and \
                 all that lie beside it. Those that touch are united.",
            ),
            Field::numbers("obstacles", "Obstacles", "", 1.0, 10_000.0).whole().help(
                "Numbers of the solids of a STEP file that are in the way: a fixture, or a part beside it. Electrodes keep clear of them as of the mold; cutters do not know them.",
            ),
            Field::number("step_tolerance_mm", "STEP tolerance", "mm", 1e-4, 1.0).step(0.001).help(
                "Greatest distance of the triangles from the exact faces of a STEP file: a twentieth of the spark \
                 gap is fine enough.",
            ),
            Field::choice_or("opening", "Opening direction", OPENINGS, "three numbers as in [0.0, 0.5, 1.0]")
                .help("The cutters come from this side."),
            Field::number("tolerance_mm", "Tolerance", "mm", 1e-4, 10.0)
                .step(0.001)
                .help("Thickness of the residue across the mold's surface up to which it counts as cut."),
        ],
    },
    Group {
        section: "Mold",
        name: "Work datum",
        is_folded: true,
        fields: &[
            Field::numbers("datum.origin_mm", "Origin", "mm", -FURTHEST, FURTHEST)
                .count(3)
                .help("Origin of the work datum in the axes of the mesh. Positions of burns refer to it."),
            Field::number("datum.angle_deg", "X axis", "deg", -360.0, 360.0)
                .decimals(2)
                .help("Angle of the datum's X axis about the opening direction, counter-clockwise seen from above. Z is the opening direction."),
            Field::text("datum.name", "Name of the datum").help("Stands in burn table, burn sheet and report."),
        ],
    },
    Group {
        section: "Mold",
        name: "Cutters",
        is_folded: false,
        fields: &[Field::rows("library.cutter", "Cutters", CUTTER, NEW_CUTTER).help(CUTTERS)],
    },
    Group {
        section: "Electrodes",
        name: "Stages",
        is_folded: false,
        fields: &[Field::rows(
            "electrodes.stages",
            "Stages",
            STAGE,
            "{ name = \"rough\", gap_mm = 0.25, finish_vdi = 32.0 }",
        )
        .first()
        .help(
            "The burns that a place goes through, each with an electrode of its own size. A new one is a \
             roughing stage.",
        )],
    },
    Group {
        section: "Electrodes",
        name: "Heads",
        is_folded: false,
        fields: &[
            Field::number("electrodes.margin_mm", "Side extension", "mm", 0.01, 20.0)
                .step(0.01)
                .help("Distance by which heads extend beyond the uncut region, where the mold allows it."),
            Field::number("electrodes.extension_mm", "Clearance above mold", "mm", 0.1, 1000.0)
                .step(0.05)
                .help("From the top of the mold to the electrode base."),
            Field::choice("electrodes.divided_at", "Divide at", DIVIDED_AT)
                .help("Inner edges of heads at which regions are divided."),
            Field::number("electrodes.overlap_mm", "Overlap", "mm", 0.0, 20.0)
                .step(0.01)
                .help("Overlap of the parts of a divided region."),
            Field::number("electrodes.least_size_mm", "Least size", "mm", 0.0, 1000.0)
                .step(0.05)
                .help("Least width of a part; a region is not divided into narrower ones."),
            Field::number("electrodes.tolerance_mm", "Allowed rest", "mm", 1e-4, 1.0).step(0.001).help(
                "Residual stock allowed across the surface, beyond what the spark gap's radius leaves in \
                 corners.",
            ),
        ],
    },
    Group {
        section: "Electrodes",
        name: "Sharing",
        is_folded: false,
        fields: &[
            Field::flag("electrodes.share", "Reuse at identical places").help("One electrode for identical places."),
            Field::number("electrodes.together_mm", "Group within", "mm", 0.0, 1000.0)
                .step(0.05)
                .help("Neighbouring heads share a base up to this width; 0 for none."),
            Field::choice("electrodes.repeat", "Identical places nearby", REPEAT)
                .when(When::Is("electrodes.share", &["true"]))
                .help("How identical places are burned that stand within the width above."),
            Field::flag("electrodes.family", "Stages on one base")
                .help("Family: electrodes of all stages for the same places on one base."),
            Field::number("electrodes.family_spacing_mm", "Distance between stages", "mm", 0.1, 1000.0)
                .step(0.05)
                .when(When::Is("electrodes.family", &["true"]))
                .help("Least distance between the heads of a family."),
        ],
    },
    Group {
        section: "Electrodes",
        name: "Base",
        is_folded: false,
        fields: &[
            Field::number("electrodes.base_height_mm", "Base height", "mm", 0.5, 1000.0)
                .step(0.05)
                .help("Least height of the base; the blank is rounded up."),
            Field::number("electrodes.base_margin_mm", "Base margin", "mm", 0.1, 1000.0)
                .step(0.05)
                .help("Distance by which the base extends beyond the heads."),
            Field::number("electrodes.datum_corner_mm", "Orientation chamfer", "mm", 0.0, 1000.0)
                .step(0.05)
                .help("Chamfer at the corner +X +Y that shows the orientation, along each side; 0 for none."),
            Field::number("electrodes.lift_mm", "Retract distance", "mm", 0.0, 10000.0)
                .step(0.05)
                .help("Least distance by which the electrode is retracted after the burn; it is always brought clear of the mold."),
            Field::number("electrodes.lift_limit_mm", "Retract limit", "mm", 0.0, 10000.0)
                .or_nothing(100.0)
                .step(0.05)
                .help("Greatest retract distance that the machine allows, no less than the one above. An electrode that needs more fails its check of the approach."),
        ],
    },
    Group {
        section: "Electrodes",
        name: "Files",
        is_folded: false,
        fields: &[
            Field::choice("electrodes.shape", "Export", SHAPES).help("Export with or without the spark gap."),
            Field::text("electrodes.material", "Material").help("Material of the electrodes."),
        ],
    },
    Group {
        section: "Electrodes",
        name: "Blanks",
        is_folded: true,
        fields: &[
            Field::numbers("electrodes.blanks.sides_mm", "Sides", "mm", 1e-3, 1e4)
                .help("Sides of rectangular blanks, rising."),
            Field::numbers("electrodes.blanks.diameters_mm", "Diameters", "mm", 1e-3, 1e4).help(
                "Diameters of round blanks, rising; used where a round blank is smaller than the rectangular \
                 one.",
            ),
            Field::number("electrodes.blanks.increment_mm", "Increment", "mm", 0.1, 100.0)
                .step(0.05)
                .help("Lengths, and sides beyond the largest, are rounded up to this."),
        ],
    },
    Group {
        section: "Electrodes",
        name: "Holders",
        is_folded: true,
        fields: &[Field::rows(
            "electrodes.holders",
            "Holders",
            HOLDER,
            "{ name = \"holder\", size_mm = [30.0, 30.0], height_mm = 20.0 }",
        )
        .help("The holders, of which the first that is large enough is taken.")],
    },
    Group {
        section: "Electrodes",
        name: "Cutters for electrodes",
        is_folded: true,
        fields: &[Field::rows("electrodes.cutters.cutter", "Electrode cutters", CUTTER, NEW_CUTTER)
            .when(When::IsNot("electrodes.cutters", &[""]))
            .help("The cutters that mill the electrodes, if not those of the mold. A new one is flat.")],
    },
    Group {
        section: "Electrodes",
        name: "Burning times",
        is_folded: true,
        fields: technology_fields!("electrodes.technology"),
    },
    Group { section: "Electrodes", name: "Set-up sheet", is_folded: true, fields: SETUP_SHEET_FIELDS },
]);

/// Name of the step from `before` to `now`, for undo.
pub fn change(before: &MoldParams, now: &MoldParams) -> String {
    if before.datum != now.datum {
        return "Work datum".to_owned();
    }
    let (old, new) = (&before.electrodes, &now.electrodes);
    if new.edits.len() < old.edits.len() {
        return "Removal of a change".to_owned();
    }
    if new.edits != old.edits {
        let name = match new.edits.last() {
            Some(Edit::Merge { .. }) => "Merged parts",
            Some(Edit::Split { .. }) => "Split part",
            Some(Edit::SplitAlong { .. }) => "Part split along a face",
            Some(Edit::Burn { .. }) => "Burn direction",
            Some(Edit::SetAside { .. }) => "Region set aside",
            Some(Edit::Join { .. }) => "Joined heads",
            Some(Edit::TakeApart { .. }) => "Head taken apart",
            Some(Edit::Copy { .. }) => "Copied electrode",
            _ => "Method of a region",
        };
        return name.to_owned();
    }
    if let Some(new) = new.overrides.iter().find(|one| !old.overrides.contains(one)) {
        return format!("Override of {}", new.of);
    }
    if new.names != old.names {
        return "Electrode by hand".to_owned();
    }
    if new.overrides != old.overrides {
        return "Override taken back".to_owned();
    }
    FIELDS.change(before, now)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::workspaces::says_labels;
    use files::Validate;
    use mold::cutter::Cutter;
    use mold::electrode::params::Stage;

    #[test]
    fn the_tables_are_sound() {
        let mut params = MoldParams::default();
        let library = params.library.clone();
        params.electrodes.cutters = Some(library.clone());
        assert_eq!(FIELDS.audit(&params, |p| p.validate().is_ok()), Vec::<String>::new());
        assert_eq!(LIBRARY.audit(&library, |p| Validate::validate(p).is_ok()), Vec::<String>::new());
    }

    #[test]
    fn the_window_says_no_key_of_any_parameter_out_of_its_range() {
        let mut params = MoldParams::default();
        params.electrodes.cutters = Some(params.library.clone());
        params.electrodes.family = true;
        let beyond = FIELDS.beyond(&params);
        assert!(beyond.len() > 40, "{}", beyond.len());
        says_labels(&FIELDS, beyond);
        // What does not go together is said in these words, too.
        let mut wrong = MoldParams::default();
        wrong.electrodes.datum_corner_mm = 5.0;
        assert!(FIELDS.in_window(&wrong.validate().unwrap_err()).starts_with("Orientation chamfer is 5 mm: must be"));
        wrong = MoldParams::default();
        wrong.library.cutter[1] = Cutter { corner_mm: 40.0, ..Cutter::flat(3.0) };
        assert!(FIELDS.in_window(&wrong.validate().unwrap_err()).starts_with("Cutters 2, Corner is 40 mm: must be"));
        wrong = MoldParams::default();
        wrong.electrodes.stages.push(Stage::finish(0.3));
        let said = FIELDS.in_window(&wrong.validate().unwrap_err());
        assert!(said.starts_with("Stages") && !said.contains("_mm"), "{said}");
    }

    #[test]
    fn a_step_is_called_after_what_was_changed() {
        let before = MoldParams::default();
        let named = |edit: fn(&mut MoldParams)| {
            let mut now = before.clone();
            edit(&mut now);
            change(&before, &now)
        };
        assert_eq!(named(|p| p.electrodes.lift_mm = 3.0), "Retract distance");
        assert_eq!(named(|p| p.datum = p.datum.at(glam::DVec3::X, "corner")), "Work datum");
        assert_eq!(named(|p| p.opening = Some(mold::opening::Opening::PlusY)), "Opening direction");
        assert_eq!(named(|p| p.library.cutter[2].diameter_mm = 3.5), "Cutters 3, Diameter");
        assert_eq!(named(|p| drop(p.library.cutter.pop())), "Cutters: row removed");
        assert_eq!(named(|p| p.electrodes.stages[0].gap_mm = 0.1), "Stages 1, Spark gap");
        assert_eq!(named(|p| p.electrodes.overrides.push("E01:gouge".parse().unwrap())), "Override of E01");
    }

    #[test]
    fn parameters_are_set_by_their_keys() {
        let set = |key: &str, text: &str| FIELDS.set(&MoldParams::default(), key, text);
        assert_eq!(set("electrodes.lift_mm", "12.5").unwrap().electrodes.lift_mm, 12.5);
        let own = set("electrodes.cutters.cutter", "[{ diameter_mm = 1.0 }]").unwrap().electrodes.cutters.unwrap();
        assert_eq!(own.cutter, [Cutter::flat(0.5)]);
        let along = |text: &str| set("opening", text).unwrap().opening.map(|opening| opening.name());
        assert_eq!(
            ["auto", "-y", "0,1,1", "[0, 1, 1]"].map(|text| along(text).unwrap_or_default()),
            ["", "-y", "0,1,1", "0,1,1"]
        );
        assert!(set("lift_mm", "1").unwrap_err().to_string().contains("did you mean electrodes.lift_mm?"));
    }
}
