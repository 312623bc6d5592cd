//! Fields of a technology table in a form: those of one technology, its steps, and its finished burns.

use burning::technology::{Technology, TechnologyFile};
use files::{Field, FieldTable, Group, Word, word};

/// The fields of a table that holds one technology. Nothing is a default in it.
pub(super) static FIELDS: FieldTable<TechnologyFile> = FieldTable::new(&[
    Group { section: "Technology", name: "What it is for", is_folded: false, fields: USE },
    Group { section: "Technology", name: "What it rests on", is_folded: false, fields: ORIGIN },
    Group { section: "Steps", name: "Steps", is_folded: false, fields: &[STEPS] },
    Group { section: "Burns", name: "Finished burns", is_folded: false, fields: &[BURNS] },
])
.with_defaults(TechnologyFile::clone);

const BASES: &[Word] = &[
    word("measured", "measured", "Measured on the machine"),
    word("vendor", "vendor", "Stated by the vendor"),
    word("fitted", "fitted", "Fitted to tables of others"),
    word("assumed", "assumed", "Assumed"),
];

const MATERIALS: &[Word] = &[
    word("graphite", "graphite", ""),
    word("copper", "copper", ""),
    word("copper-tungsten", "copper-tungsten", ""),
    word("other", "other", "Another material; the grade says which"),
];

const POLARITIES: &[Word] = &[
    word("", "not given", ""),
    word("positive", "positive", "The electrode is the anode"),
    word("negative", "negative", "The electrode is the cathode"),
];

const USE: &[Field] = &[
    Field::text("technology[0].id", "Identifier").help("Unique in the table; projects and finished burns name it."),
    Field::text("technology[0].title", "Title").help("Name in lists; the identifier where it is empty."),
    Field::choice("technology[0].electrode_material", "Electrode", MATERIALS).help("Material of the electrode."),
    Field::text("technology[0].electrode_grade", "Grade")
        .help("Grade of the electrode's material, such as the grain size of graphite."),
    Field::text("technology[0].workpiece", "Workpiece").help("Material of the workpiece."),
    Field::choice("technology[0].polarity", "Polarity", POLARITIES)
        .help("Polarity of the electrode against the workpiece."),
    Field::text("technology[0].machine", "Machine").help("Machine that the figures are for."),
    Field::text("technology[0].generator", "Generator").help("Generator that the figures are for."),
];

const ORIGIN: &[Field] = &[
    Field::choice("technology[0].basis", "Basis", BASES)
        .help("Foundation of the figures; the weakest, where they differ."),
    Field::text("technology[0].source", "Source").help("Origin of the figures, and the range in which they are valid."),
    Field::text("technology[0].licence", "Licence").help("Licence of the figures."),
    Field::text("technology[0].date", "Date").help("Date of the figures, as year-month-day."),
    Field::text("technology[0].dielectric", "Dielectric").help("Dielectric fluid."),
    Field::text("technology[0].flushing", "Flushing").help("How the gap is flushed."),
    Field::numbers("technology[0].area_range_mm2", "Frontal areas", "mm²", 1e-3, 1e7)
        .count(2)
        .optional()
        .help("Least and greatest frontal area for which the figures are valid."),
    Field::number("technology[0].greatest_depth_to_width", "Depth to width", "", 0.01, 1000.0)
        .decimals(1)
        .or_nothing(5.0)
        .help("Greatest ratio of depth to width for which the figures are valid."),
];

const fn figure(key: &'static str, label: &'static str, unit: &'static str, least: f64, greatest: f64) -> Field {
    Field::number(key, label, unit, least, greatest).or_nothing(least)
}

const STEPS: Field = Field::rows(
    "technology[0].step",
    "Steps",
    &[
        Field::text("name", "Name").help("Unique in the technology."),
        Field::text("vendor_code", "Code").help("Code by which the machine calls this setting."),
        figure("vdi", "VDI", "", -20.0, 60.0).decimals(1).help("Finish that the step leaves (VDI 3400)."),
        figure("ra_um", "Ra", "µm", 0.01, 100.0).decimals(2).help("Arithmetic mean roughness that the step leaves."),
        figure("ip_a", "Current", "A", 1e-3, 2000.0).decimals(1).symbol("IP").help("Peak current."),
        figure("on_us", "On", "µs", 1e-3, 1e5).decimals(1).help("Pulse duration."),
        figure("off_us", "Off", "µs", 1e-3, 1e5).decimals(1).help("Pause between pulses."),
        figure("servo_v", "Servo", "V", 0.0, 1000.0).decimals(0).help("Servo voltage."),
        figure("open_v", "Open", "V", 1.0, 1000.0).decimals(0).help("Open-circuit voltage."),
        figure("gap_side_mm", "Gap side", "mm", 1e-4, 5.0)
            .decimals(4)
            .symbol("side gap")
            .help("Spark gap at the sides, a side."),
        figure("gap_front_mm", "Gap front", "mm", 1e-4, 5.0)
            .decimals(4)
            .symbol("front")
            .help("Spark gap at the front."),
        figure("rate_mm3_min", "Rate", "mm³/min", 1e-6, 1e5)
            .decimals(2)
            .symbol("rate")
            .help("Removal rate, without jumps."),
        figure("at_area_mm2", "At area", "mm²", 1e-3, 1e7)
            .decimals(1)
            .symbol("at area")
            .help("Frontal area at which the rate is stated."),
        figure("max_density_a_cm2", "Density", "A/cm²", 1e-3, 1e4)
            .decimals(2)
            .symbol("density")
            .help("Greatest peak current per frontal area."),
        figure("wear_percent", "Wear", "%", 0.0, 1000.0)
            .decimals(2)
            .symbol("wear")
            .help("Volume that the electrode loses, in percent of the volume that it removes."),
        figure("corner_wear_mm", "Corner wear", "mm", 0.0, 50.0)
            .decimals(3)
            .symbol("corner")
            .help("Wear of the electrode's edges in one burn."),
        figure("orbit_mm", "Orbit", "mm", 0.0, 50.0).decimals(3).symbol("orbit").help("Radius of the orbit."),
        figure("stock_next_mm", "Stock next", "mm", 1e-4, 50.0)
            .decimals(4)
            .symbol("stock")
            .help("Thickness of the layer that the step leaves for the next step."),
        figure("jump_mm", "Jump", "mm", 0.0, 1000.0).decimals(2).symbol("jump").help("Height of a jump."),
        figure("jump_every_s", "Jump every", "s", 1e-2, 1e5)
            .decimals(2)
            .symbol("every")
            .help("Time of burning between two jumps."),
        figure("jump_speed", "Jump speed", "mm/min", 1.0, 1e5)
            .decimals(0)
            .symbol("speed")
            .help("Speed of a jump, up and down."),
        figure("recast_um", "Recast", "µm", 0.0, 1000.0)
            .decimals(1)
            .symbol("recast")
            .help("Thickness of the recast layer."),
    ],
    "{ name = \"S\" }",
)
.help("One setting of the generator each, from rough to fine. A figure that is not known stays empty.");

const BURNS: Field = Field::rows(
    "calibration",
    "Finished burns",
    &[
        Field::number("estimated_min", "Estimated", "min", 1e-3, 1e7)
            .decimals(1)
            .help("Estimated minutes of burning with jumps, without set-up and changing, not calibrated."),
        Field::number("measured_min", "Measured", "min", 1e-3, 1e7).decimals(1).help("Measured minutes of the same."),
        Field::text("date", "Date").help("Date of the burn, as year-month-day."),
        Field::text("source", "Source").help("Origin of the measurement."),
    ],
    "{ technology = \"\", estimated_min = 60.0, measured_min = 60.0 }",
)
.help("Estimates are scaled by the ratio of measured to estimated minutes.");

/// Empty texts are none.
pub(super) fn tidied(mut table: TechnologyFile) -> TechnologyFile {
    let tidy = |text: &mut Option<String>| drop(text.take_if(|text| text.trim().is_empty()));
    for technology in &mut table.technology {
        let Technology { machine, generator, licence, date, electrode_grade, dielectric, flushing, .. } = technology;
        [machine, generator, licence, date, electrode_grade, dielectric, flushing].into_iter().for_each(tidy);
        technology.step.iter_mut().for_each(|step| tidy(&mut step.vendor_code));
    }
    for burn in &mut table.calibration {
        [&mut burn.date, &mut burn.source].into_iter().for_each(tidy);
    }
    table
}

#[cfg(test)]
mod tests {
    use super::*;
    use burning::defaults;
    use burning::technology::Calibration;
    use files::Validate as _;

    #[test]
    fn every_field_is_there_and_has_the_range_of_the_table() {
        let mut file = defaults::standard().unwrap();
        file.technology.truncate(1);
        let id = file.technology[0].id.clone();
        let burn = Calibration { technology: id, estimated_min: 60.0, measured_min: 70.0, date: None, source: None };
        file.calibration = vec![burn];
        let faults = FIELDS.audit(&file, |params| params.validate().is_ok());
        assert!(faults.is_empty(), "{faults:#?}");
    }
}
