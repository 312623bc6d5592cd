//! Where a ball-end cutter can come, exactly.
//!
//! A ball rests against faces, edges and corners of the mold. Its centre is free where the mold is no nearer than its
//! radius; what it leaves at a place is told by the free centre that comes lowest there. That centre is found by
//! descent: at a free centre every near face is shut off by a plane between it and the ball, the best centre between
//! these planes is found exactly, and from there anew. Every centre on the way is free, so that no residue is ever told
//! too small; where to start is told by a lattice of balls at rest around the place.

pub mod ball;
mod halfspaces;
mod obstacles;
#[cfg(test)]
mod tests;
