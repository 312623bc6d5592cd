//! Floor 5: what is shown of a job: tracks of poses to step through, and scenes for the window, for pictures in
//! reports and for `sparkpath render`. Computes nothing that a result depends on.

mod camera;
mod caps;
mod colours;
mod electrode_pictures;
mod electrodes;
mod flank;
mod leftover;
mod machine;
mod mold;
mod pictures;
mod scene;
mod shapes;
mod sweep;
mod track;
mod values;

pub use camera::{NamedView, bodies, into_channel, standard};
pub use colours::mesh_colour;
pub use electrode_pictures::{ElectrodePicture, electrode_pictures};
pub use electrodes::{
    BurnCut, BurnOf, BurnPhase, BurnWay, ElectrodeScene, ElectrodeShape, electrode_colour, electrode_shapes,
};
pub use flank::{FlankScene, FlankShapes, FlankSurface, contact_line, flank_surface_of};
pub use leftover::{LeftoverShape, colour_limit, leftover_legend};
pub use machine::{BodyShape, MachineBody, Moment, WholeMotion, body_shapes, meeting};
pub use mold::{
    MoldLayer, MoldLook, MoldPart, MoldScene, RegionColours, RegionShape, build_mold, depth_legend, faces_shape,
    mold_part, region_colour, region_shapes,
};
pub use pictures::{PICTURE_SIZE, PlanPicture, PlanToShow, plan_pictures};
pub use scene::{Layer, Layers, Look, SceneInputs, build, layer_id, layer_of};
pub use shapes::{ChannelShapes, channel_shapes};
pub use sweep::{COARSE, FINE, placements, swept_shape};
pub use track::{Station, Track};
pub use values::clearance_at_vertices;
