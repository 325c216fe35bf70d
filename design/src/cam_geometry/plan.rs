//! The prescribed geometry of a cam, in addition to its motion law.

use super::checks::worst;
use super::{Cam, Follower, Limits, Side};
use camdrive::drives::Fault;
use camdrive::motion::MotionLaw;

/// The follower that carries the roller, without its start.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Carrier {
    /// As [`Follower::Lever`].
    Lever {
        /// d (m).
        pivot: f64,
        /// l (m).
        length: f64,
        /// R (m/rad), of an angular law (1).
        transmission: f64,
        /// s = ±1.
        side: f64,
    },
    /// As [`Follower::Translating`].
    Translating {
        /// e (m).
        eccentricity: f64,
    },
    /// As [`Follower::Flat`].
    Flat,
}

/// The value that fixes the size of the cam.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Start {
    /// ψ₀ (rad) or h₀ (m), at U = 0.
    Coordinate(f64),
    /// The radius of the prime circle, the least distance of the roller's centre from the cam's centre (m).
    Prime(f64),
    /// The radius of the base circle, the prime circle's less the roller's (m); for a flat face its least height.
    Base(f64),
}

/// The second roller of a conjugate pair.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Second {
    /// λ (rad) between both arms of a lever; the distance of both rollers of a translating follower (m).
    pub place: f64,
    /// l₂ of a lever (m).
    pub length: f64,
    /// ϱ₂ (m).
    pub roller: f64,
}

/// The flanks to cut.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Cut {
    /// A disc that the roller runs on from outside.
    Inner,
    /// A ring that the roller runs in.
    Outer,
    /// Both: the roller runs in a groove.
    Groove,
    /// Two discs with a roller each, which hold the follower between them.
    Conjugate(Second),
}

/// The geometry of a cam.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Plan {
    /// The follower.
    pub carrier: Carrier,
    /// True if U is an angle (rad) that moves a lever; false if it is a length.
    pub angular: bool,
    /// Its start.
    pub start: Start,
    /// σ.
    pub sense: f64,
    /// ϱ (m); for a flat face the cutter's.
    pub roller: f64,
    /// The flanks.
    pub cut: Cut,
    /// Admissible values.
    pub limits: Limits,
}

impl Cut {
    /// The contours of each cam.
    pub fn sides(self) -> &'static [Side] {
        match self {
            Cut::Inner | Cut::Conjugate(_) => &[Side::Inner],
            Cut::Outer => &[Side::Outer],
            Cut::Groove => &[Side::Inner, Side::Outer],
        }
    }
}

impl Plan {
    /// The cams for this law with their names: one without name, or F and P of a conjugate pair.
    ///
    /// # Errors
    /// A base or prime circle that no follower of these lengths has.
    pub fn cams(&self, law: &MotionLaw) -> Result<Vec<(&'static str, Cam)>, Fault> {
        let cam = self.first(law)?;
        Ok(match self.cut {
            Cut::Conjugate(second) => {
                let other = cam.conjugate(second);
                vec![("F", cam), ("P", other)]
            }
            _ => vec![("", cam)],
        })
    }

    /// True if this is the first cam of a pair: its lever is on the planned side, its translating roller above the cam's centre.
    pub fn is_first(&self, cam: &Cam) -> bool {
        match (self.carrier, cam.follower, self.cut) {
            (Carrier::Lever { side, .. }, Follower::Lever { side: own, .. }, _) => side == own,
            (Carrier::Translating { .. }, Follower::Translating { start, .. }, Cut::Conjugate(second)) => {
                self.first(&cam.law).is_ok_and(|first| match first.follower {
                    Follower::Translating { start: own, .. } => (start - own).abs() < 0.5 * second.place,
                    _ => false,
                })
            }
            _ => true,
        }
    }

    fn first(&self, law: &MotionLaw) -> Result<Cam, Fault> {
        let with = |start: f64| self.with(law.clone(), start);
        let radius = match self.start {
            Start::Coordinate(start) => return Ok(with(start)),
            Start::Prime(radius) => radius,
            Start::Base(radius) => radius + self.roller,
        };
        // The least coordinate belongs to the prime circle.
        let unplaced = with(0.0);
        let lowest = |segment: usize, phi: f64| Ok(-unplaced.follower.coordinate(law.at_in(segment, phi).0[0]));
        let (_, depth) = worst(&unplaced, lowest).map_err(Fault::from)?;
        Ok(with(self.coordinate_at(radius)? + depth))
    }

    /// The cam, or the first one of a pair, whose follower has the coordinate `start` at U = 0.
    pub(super) fn with(&self, law: MotionLaw, start: f64) -> Cam {
        Cam { law, follower: self.follower(start), sense: self.sense, roller: self.roller }
    }

    /// The follower with this coordinate at U = 0.
    pub(super) fn follower(&self, start: f64) -> Follower {
        match self.carrier {
            Carrier::Lever { pivot, length, transmission, side } => {
                Follower::Lever { pivot, length, start, transmission, side }
            }
            Carrier::Translating { eccentricity } => Follower::Translating { eccentricity, start },
            Carrier::Flat => Follower::Flat { start },
        }
    }

    /// ψ or h at this distance of the roller's centre from the cam's centre; for a flat face at rest.
    pub(super) fn coordinate_at(&self, distance: f64) -> Result<f64, Fault> {
        let millimetres = |length: f64| format!("{} mm", (1e9 * length).round() / 1e6);
        match self.carrier {
            Carrier::Lever { pivot, length, .. } => {
                let (least, most) = ((pivot - length).abs(), pivot + length);
                if !(distance > least && distance < most) {
                    return Err(Fault::new(format!(
                        "the prime circle has a radius of {}: a lever of {} about a pivot at {} puts the roller's centre between {} and {} from the cam's centre",
                        millimetres(distance),
                        millimetres(length),
                        millimetres(pivot),
                        millimetres(least),
                        millimetres(most)
                    )));
                }
                // Half the angle from the three sides: accurate for a small angle, too.
                let (below, above) = ((distance - least) * (distance + least), (most - distance) * (most + distance));
                Ok(2.0 * below.sqrt().atan2(above.sqrt()))
            }
            Carrier::Translating { eccentricity } => {
                let e = eccentricity.abs();
                if distance <= e || distance.is_nan() {
                    return Err(Fault::new(format!(
                        "the prime circle has a radius of {}, which must be larger than the offset of {}",
                        millimetres(distance),
                        millimetres(e)
                    )));
                }
                Ok(((distance - e) * (distance + e)).sqrt())
            }
            Carrier::Flat => Ok(distance - self.roller),
        }
    }
}
