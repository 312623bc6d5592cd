//! Figures of P3 that hold nothing to compare: drawings of ideas, flow charts, a listing, a menu.

use super::{Outcome, blank};

/// Number, subject, reason, and where the same thing is in the program.
const DRAWINGS: [(&str, &str, &str, &str); 12] = [
    (
        "Figure 1",
        "Flow chart of the method",
        "A chart has no figures. The steps are the same: undercut faces, layers, uncut segments of flat and ball cutters, \
         regions, division, electrodes. Checks of every electrode follow here.",
        "sparkpath electrodes MESH; window: mold workspace, panels from top to bottom",
    ),
    (
        "Figure 4",
        "Flat-end, ball-end and nose-end cutters",
        "A drawing. The paper leaves out nose-end cutters because flat and ball cutters leave no more; that holds only if \
         the library has a ball no larger than the corner radius, so that bull-nose cutters are followed here as well.",
        "--cutters flat:1,ball:1,bull:2:0.5; window: table of cutters",
    ),
    ("Figure 5", "A flat cutter at a point of a wall", "A drawing without dimensions.", "none"),
    (
        "Figure 6",
        "Proof of theorem 1: molds without and with undercut faces",
        "A drawing. The theorem looks at one layer at a time, which is exact without undercut faces only; here each layer \
         is united with the shadow of what lies above it, so that undercut faces need not be left out.",
        "sparkpath uncut MESH, with any mesh of this folder; src/engines/mold/invert.rs",
    ),
    (
        "Figure 9",
        "Flow chart of the flat-end cutter",
        "A chart has no figures. Both kinds of interference are found in one walk of the cutter's centre around all \
         curves of a layer.",
        "src/engines/mold/uncut_layer.rs",
    ),
    (
        "Figure 11",
        "P-region of a curve and the curves that interfere with it",
        "A drawing without dimensions. P-regions are not made: curves within a diameter are found by a grid of squares.",
        "src/engines/mold/centre_path.rs",
    ),
    (
        "Figure 13",
        "Listing of the minimum-distance algorithm",
        "A listing; what it decides is compared at figure 12.",
        "src/engines/mold/centre_path.rs",
    ),
    (
        "Figure 23",
        "A face that is uncut in part",
        "A drawing without dimensions; the effect is compared at figure 19.",
        "none",
    ),
    (
        "Figure 24",
        "Steps of the extruding method",
        "A drawing without dimensions. The number of regions made by either method is at figure 29.",
        "window: division panel, method of a region; [electrodes] edits in the project file",
    ),
    (
        "Figure 25",
        "Steps of the cutting method",
        "A drawing without dimensions. The number of regions made by either method is at figure 29.",
        "window: division panel, method of a region; [electrodes] edits in the project file",
    ),
    (
        "Figure 28",
        "Menu and dialog of the system",
        "An interface. Datum, uncut detection, division, electrodes, holders and attributes are one workspace here.",
        "sparkpath mold MESH",
    ),
    (
        "Figure 2",
        "Result of each step on the example mold",
        "The example mold is not public and no figures are given for it. The steps on the demonstration mold are at \
         figures 7, 18 and 29.",
        "sparkpath mold",
    ),
];

pub(super) fn outcomes() -> Vec<Outcome> {
    let of = |(name, title, why, by_hand): &(&str, &str, &str, &str)| Outcome {
        why: (*why).to_owned(),
        by_hand: (*by_hand).to_owned(),
        ..blank(name, title, "none")
    };
    DRAWINGS.iter().map(of).collect()
}
