//! The colours of bodies: quiet, and told apart on dark and on light ground.

use render::colour::Colour;

/// Metal of the blisk.
pub const STEEL: Colour = Colour::rgb(0x9d, 0xab, 0xba);
/// Electrodes.
pub const COPPER: Colour = Colour::rgb(0xd0, 0x83, 0x4f);
/// Electrodes elsewhere on their way.
pub const GHOST: Colour = Colour::rgb(0xe0, 0xb0, 0x8a);
/// The low wall.
pub const LOW: Colour = Colour::rgb(0x6f, 0xa8, 0xa0);
/// The high wall.
pub const HIGH: Colour = Colour::rgb(0x8a, 0x96, 0xc8);
/// Bodies of a machine.
pub const MACHINE: Colour = Colour::rgb(0x7d, 0x86, 0x8c);
/// Where something is too near.
pub const BAD: Colour = Colour::rgb(0xe5, 0x48, 0x4d);

/// Of the mesh that is number `i`, from 0, of those shown together: no two of six are alike.
pub fn mesh_colour(i: usize) -> Colour {
    const OTHERS: [Colour; 6] =
        [STEEL, COPPER, LOW, HIGH, Colour::rgb(0xc9, 0xb4, 0x5a), Colour::rgb(0xb5, 0x7f, 0xa8)];
    OTHERS[i % OTHERS.len()]
}
