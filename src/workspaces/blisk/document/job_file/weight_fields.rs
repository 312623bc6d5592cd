//! The weights of the objectives of a path.

use files::{Field, Group};

const fn weight(key: &'static str, label: &'static str) -> Field {
    Field::number(key, label, "", 0.0, f64::INFINITY).slider(0.0, 1.0).decimals(2)
}

/// The weights.
pub(super) const WEIGHTS: Group = Group {
    section: "Plan",
    name: "Weights",
    is_folded: true,
    fields: &[
        weight("plan.weights.a3", "Smoothness")
            .symbol("a3")
            .help("Weight of smooth motion against centring; only the ratio of the two counts."),
        weight("plan.weights.b3", "Centring").symbol("b3").help("Weight of staying in the middle of the channel."),
        weight("plan.weights.a1", "Smooth Z")
            .symbol("a1")
            .help("Weight of Z among the axes; of X for an electrode from the rim."),
        weight("plan.weights.b1", "Smooth Y").symbol("b1").help("Weight of Y among the axes."),
        weight("plan.weights.c1", "Smooth C").symbol("c1").help("Weight of C among the axes."),
        weight("plan.weights.d1", "Smooth A")
            .help("Weight of A among the axes, where the machine has it; the paper keeps A still."),
        weight("plan.weights.e1", "Smooth B").help("Weight of B among the axes, where the machine has it."),
        weight("plan.weights.a2", "Equal distances")
            .symbol("a2")
            .help("Weight of equal least distances to both walls."),
        weight("plan.weights.b2", "Even along low wall")
            .symbol("b2")
            .help("Weight of even distances along the low wall (the paper's left)."),
        weight("plan.weights.c2", "Even along high wall")
            .symbol("c2")
            .help("Weight of even distances along the high wall (the paper's right)."),
    ],
};
