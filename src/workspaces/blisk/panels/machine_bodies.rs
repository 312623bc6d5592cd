//! The bodies of the machine about the electrode that is shown: read on a thread of its own, since they may be meshes, and
//! stood anew when electrode, blisk or what was found out about them is another.

use std::sync::Arc;

use crate::workspaces::blisk::document::machine_file::read_machine;
use crate::workspaces::blisk::job::stages::FoundChannel;
use crate::workspaces::blisk::scene::machine::{BodyShape, MachineBody, body_shapes};
use crate::workspaces::worker::{Ended, Message, Worker};
use feed::machine_model::Station;
use feed::simulation::Simulation;
use render::mesh::RenderMesh;
use wheel::electrode::Electrode;

/// The name of a machine, and how often its file was read.
type Wanted = (String, u64);

/// See the module's page.
pub struct MachineBodies {
    reader: Worker<(), (Wanted, Arc<Vec<BodyShape>>)>,
    asked: Option<Wanted>,
    read: Option<(Wanted, Arc<Vec<BodyShape>>)>,
    failure: Option<String>,
    stood: Stood,
}

/// Bodies as they stand.
#[derive(Default)]
pub struct Stood {
    about: Option<About>,
    bodies: Arc<Vec<MachineBody>>,
}

/// What bodies stand about.
struct About {
    bodies: Arc<Vec<BodyShape>>,
    shape: Arc<RenderMesh>,
    channel: Arc<FoundChannel>,
    simulation: Option<Arc<Simulation>>,
}

impl About {
    fn is(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.bodies, &other.bodies)
            && Arc::ptr_eq(&self.shape, &other.shape)
            && Arc::ptr_eq(&self.channel, &other.channel)
            && self.simulation.as_ref().map(Arc::as_ptr) == other.simulation.as_ref().map(Arc::as_ptr)
    }
}

impl MachineBodies {
    /// None yet; `wake` is called whenever there is something new.
    ///
    /// # Errors
    /// If the system gives no thread.
    pub fn start(wake: impl Fn() + Send + Sync + 'static) -> std::io::Result<Self> {
        Ok(Self { reader: Worker::start(wake)?, asked: None, read: None, failure: None, stood: Stood::default() })
    }

    /// Reads the machine that is wanted, unless that was done.
    pub fn read(&mut self, wanted: Option<Wanted>) {
        for message in self.reader.messages() {
            match message {
                Message::Finished(_, Ended::Done(read)) => self.read = Some(read),
                Message::Finished(_, Ended::Failed(why) | Ended::Panicked(why)) => self.failure = Some(why),
                _ => {}
            }
        }
        if self.asked == wanted {
            return;
        }
        self.asked = wanted.clone();
        match wanted {
            None => self.reader.cancel_from(0),
            Some(wanted) => {
                self.reader.submit(0, move |_, task| {
                    let model = read_machine(&wanted.0, task).map_err(|e| e.to_string())?;
                    Ok((wanted, Arc::new(body_shapes(&model))))
                });
            }
        }
    }

    /// How they stand about `electrode`, which has this shape, in the channel; `simulation` tells what is in the way. None
    /// if they do already.
    pub fn anew(
        &self,
        electrode: Option<(&Electrode, &Arc<RenderMesh>)>,
        channel: Option<&Arc<FoundChannel>>,
        simulation: Option<&Arc<Simulation>>,
    ) -> Option<Stood> {
        let bodies = self.read.as_ref().filter(|(of, _)| self.asked.as_ref() == Some(of)).map(|(_, bodies)| bodies);
        let (Some((electrode, shape)), Some(channel), Some(bodies)) = (electrode, channel, bodies) else {
            return self.stood.about.is_some().then(Stood::default);
        };
        let (bodies, shape, channel) = (bodies.clone(), shape.clone(), channel.clone());
        let about = About { bodies, shape, channel, simulation: simulation.cloned() };
        if self.stood.about.as_ref().is_some_and(|known| known.is(&about)) {
            return None;
        }
        let (o, side) = (electrode.reference_point, electrode.enters_from);
        let station = Station::new(&electrode.mesh, o, side, &about.channel.blisk);
        let stands = |body: &BodyShape| MachineBody::standing(body, &station, simulation.map(|s| &**s));
        let bodies = Arc::new(about.bodies.iter().map(stands).collect());
        Some(Stood { about: Some(about), bodies })
    }

    /// Takes over how they stand.
    pub fn take_over(&mut self, stood: Stood) {
        self.stood = stood;
    }

    /// The bodies as they stand.
    pub fn standing(&self) -> &Arc<Vec<MachineBody>> {
        &self.stood.bodies
    }

    /// Why they could not be read, once.
    pub fn take_failure(&mut self) -> Option<String> {
        self.failure.take()
    }
}
