//! What the FMU of a machine brings along: what follows from the scene and would take longer to compute than to read.
//!
//! It holds for the parameters of the scene; where one is changed the table of J is made anew. The first guess only says
//! where a search begins.

use super::RigidMachine;
use super::profile::Profile;
use super::raster::Raster;
use crate::drives::Fault;
use serde::{Deserialize, Serialize};
use std::sync::Arc;

#[derive(Serialize, Deserialize)]
struct Tables<P> {
    /// J(φ).
    profile: P,
    /// The bounds of J [kg·m²].
    range: (f64, f64),
    /// The harmonic order that resolves the inertia of the followers with mechanisms.
    linked_resolution: f64,
    /// E at the beginning of the turn on the periodic motion without load, over that of the mean √J at the synchronous
    /// speed.
    first_guess: f32,
}

impl RigidMachine {
    /// Takes the tables that were made for its scene.
    pub(super) fn take(&mut self, bytes: &[u8]) -> Result<(), Fault> {
        let read: Tables<Profile> =
            postcard::from_bytes(bytes).map_err(|e| Fault(format!("the tables of the machine cannot be read: {e}")))?;
        let Tables { profile, range, linked_resolution, first_guess } = read;
        if !profile.fits(&self.inertia) {
            return Err(Fault::new("the tables of the machine are not those of its scene"));
        }
        let own = Arc::make_mut(&mut self.inertia);
        own.know(range, linked_resolution);
        self.first_guess = first_guess;
        let tolerance = self.solver.effective_tolerance();
        self.raster = Raster::on(Arc::new(profile), &self.inertia, &self.motor, tolerance)?;
        Ok(())
    }
}

#[cfg(feature = "cli")]
mod written {
    use super::super::steady::{ORBIT_TOLERANCE, Shooting};
    use super::super::torques::Torques;
    use super::super::{Motor, RigidMachine};
    use super::Tables;
    use crate::drives::Fault;

    impl RigidMachine {
        /// The tables of this machine.
        pub(in super::super) fn written_tables(&self) -> Result<Vec<u8>, Fault> {
            let tables = Tables {
                profile: &*self.raster.profile,
                range: self.inertia.range(),
                linked_resolution: self.inertia.linked_resolution(),
                first_guess: self.guess().map_or(1.0, |guess| guess as f32),
            };
            postcard::to_stdvec(&tables).map_err(|e| Fault(format!("the tables of the machine cannot be written: {e}")))
        }

        /// Where the only periodic motion is.
        fn guess(&self) -> Option<f64> {
            let Motor::Kloss { synchronous_speed, .. } = self.motor else { return None };
            let torques = Torques::against(&self.motor, 0.0, synchronous_speed.signum());
            let shooting = Shooting::new(self, torques, ORBIT_TOLERANCE, None).ok()?;
            let (low, high) = self.inertia.range();
            let (energy, _) = shooting.refine(torques.only_orbit(low, high)?)?;
            Some(energy / shooting.first_energy()?)
        }
    }
}
