//! The parameters of burning: the technology, and how a wheel is burned.

use files::{Field, Group, When, Word, word};

use crate::workspaces::technology::technology_fields;

const ORDERS: &[Word] = &[
    word("by-electrode", "by electrode", "All channels with the first electrode, then all with the next one"),
    word("by-channel", "by channel", "Each channel with all electrodes before the next channel"),
];

/// The technology.
pub(super) const TECHNOLOGY: Group =
    Group { section: "Plan", name: "Technology", is_folded: true, fields: technology_fields!("technology") };

/// Burning with it.
pub(super) const BURNING: Group = Group {
    section: "Plan",
    name: "Burning",
    is_folded: true,
    fields: &[
        Field::text("burning.last_step", "Last step")
            .help("Name of the step of the technology at which burning ends; empty: at the finish below."),
        Field::number("burning.finish_vdi", "Finish", "VDI", -20.0, 60.0)
            .decimals(1)
            .or_nothing(24.0)
            .when(When::Is("burning.last_step", &[""]))
            .help("Surface finish at which burning ends (VDI 3400). Minutes are known with a last step or a finish."),
        Field::number("burning.indexing_min", "Indexing", "min", 0.0, 1e6)
            .decimals(1)
            .help("Turning the wheel to another channel."),
        Field::choice("burning.order", "Order", ORDERS)
            .help("Order in which all channels of the wheel are burned with all electrodes."),
        Field::number("burning.allowance_mm", "Allowance", "mm", 1e-3, 100.0)
            .decimals(3)
            .or_nothing(0.5)
            .help("Stock on the surfaces of the channels of a wheel that was cast, printed or roughed before; none of a full ring."),
        Field::file("burning.blank", "Blank").help(
            "Mesh of the wheel as it comes, in the coordinates of the finished one; none of a full ring. Only what lies in it is \
             burned.",
        ),
    ],
};
