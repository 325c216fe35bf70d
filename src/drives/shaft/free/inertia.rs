//! The reduced moment of inertia J(φ).

use crate::drives::Fault;
use crate::drives::follower::place::{Place, ends, into_turn, pieces};
use crate::drives::follower::rigid::Follower;
use crate::drives::parameter::parameters;
use crate::motion::MotionLaw;
use crate::numerics::work::note;
use serde::{Deserialize, Serialize};
use std::f64::consts::TAU;
use std::sync::OnceLock;

/// The part of J(φ) that does not come from the followers.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct InertiaFunction {
    /// J0 (kg·m²).
    pub constant: f64,
    /// A 2π-periodic addition (kg·m²): a Fourier series or a table. Its derivatives are the interpolant's, so that energy is
    /// conserved.
    pub varying: Option<MotionLaw>,
}

parameters! {
    for InertiaFunction, "machine" {
        /// Constant part of the reduced moment of inertia
        constant = "J0", "J0", INERTIA in [0.0, 1e12], Fixed;
    }
}

/// J(φ) = J0 + J_v(φ) + Σ m_j U_j′(φ)². With mechanisms between cam and tool the inertia of tool and links replaces the last term.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Inertia {
    /// J0 and J_v.
    pub function: InertiaFunction,
    /// m_j, U_j and the mechanisms.
    pub followers: Vec<Follower>,
    /// The angles in [0, 2π), ascending, at which one of the laws has a breakpoint.
    borders: Vec<f64>,
    #[serde(skip)]
    cache: Cache,
}

/// Values derived from the rest of the inertia on demand; they do not count in comparisons.
#[derive(Clone, Debug, Default)]
struct Cache {
    range: OnceLock<(f64, f64)>,
    linked_resolution: OnceLock<f64>,
}

impl PartialEq for Cache {
    fn eq(&self, _: &Self) -> bool {
        true
    }
}

/// Cost of an evaluation of J among many over the cost of one in a step: with it a nominal microsecond takes equally long in both,
/// measured on machines of 2 and 8 followers with 256 harmonics.
pub const IN_A_ROW: f64 = 0.4;

/// Borders that lie closer together count as one: the interval between them would be lost in rounding.
const SAME_BORDER: f64 = 1e-12;

impl Inertia {
    /// The inertia of these parts.
    pub fn new(function: InertiaFunction, followers: Vec<Follower>) -> Self {
        let mut inertia = Inertia { function, followers, ..Inertia::default() };
        inertia.find_borders();
        inertia
    }

    /// Whether mechanisms lie between a cam and its tool.
    pub fn is_linked(&self) -> bool {
        self.followers.iter().any(|follower| !follower.linkage.is_empty())
    }

    /// The order that resolves the inertia of the followers with mechanisms; 0 without mechanisms, infinite if it takes more than
    /// the work of a call.
    pub fn linked_resolution(&self) -> f64 {
        *self.cache.linked_resolution.get_or_init(|| {
            let linked = self.followers.iter().filter(|follower| !follower.linkage.is_empty());
            linked.map(Follower::linked_resolution).fold(0.0, f64::max)
        })
    }

    /// The laws of the parts.
    fn laws(&self) -> impl Iterator<Item = &MotionLaw> {
        self.followers.iter().map(|f| &f.cam).chain(&self.function.varying)
    }

    /// Changes the parts.
    pub fn change(&mut self, change: impl FnOnce(&mut InertiaFunction, &mut [Follower])) {
        change(&mut self.function, &mut self.followers);
        self.find_borders();
        self.cache = Cache::default();
    }

    /// J0 and J_v, to change numbers that move no border.
    pub fn function_mut(&mut self) -> &mut InertiaFunction {
        self.cache = Cache::default();
        &mut self.function
    }

    /// Collects the breakpoints of all laws.
    fn find_borders(&mut self) {
        let mut all: Vec<f64> = self.laws().flat_map(|law| law.breakpoints().iter().copied()).collect();
        all.sort_by(f64::total_cmp);
        all.dedup_by(|b, a| *b - *a <= SAME_BORDER);
        self.borders = all;
    }

    /// Whether the parameters of the laws, as set by a user, make laws.
    pub fn validate(&self) -> Result<(), Fault> {
        for (j, follower) in self.followers.iter().enumerate() {
            let follower_j = format!("follower[{}]", j + 1);
            let of_cam = |reason| Fault::new(format!("{follower_j}: {reason}")).of(format!("{follower_j}.cam"));
            follower.cam.validate().map_err(of_cam)?;
            follower.check_linkage(&format!("{follower_j}.linkage"))?;
        }
        if self.linked_resolution().is_infinite() {
            return Err(Fault::new(
                "the inertia of the mechanisms changes too fast with the angle of the shaft to be resolved; choose \
                        longer rises and returns of the levers, or keep farther away from positions where the output of a \
                        mechanism may go either way",
            ));
        }
        self.function
            .varying
            .iter()
            .try_for_each(|law| law.validate().map_err(|reason| Fault::new(format!("inertia: {reason}")).of("inertia")))
    }

    /// The angles in [0, 2π) at which J is not smooth.
    pub fn borders(&self) -> &[f64] {
        &self.borders
    }

    /// Cost of an evaluation of J (nominal µs), see [`crate::numerics::work`].
    pub fn cost(&self) -> f64 {
        self.followers.iter().map(Follower::cost).sum::<f64>()
            + self.function.varying.as_ref().map_or(0.0, MotionLaw::cost)
    }

    /// Whether J depends on φ.
    pub fn varies(&self) -> bool {
        !self.followers.is_empty() || self.function.varying.is_some()
    }

    /// J, J′, J″, J‴ (kg·m²/radⁿ) at `phi`, continued smoothly from the place `inside`.
    ///
    /// J′ = J_v′ + Σ 2 m U′U″, J″ = J_v″ + Σ 2 m (U″² + U′U‴), J‴ = J_v‴ + Σ 2 m (3 U″U‴ + U′U⁗).
    pub fn at(&self, place: Place, phi: f64) -> [f64; 4] {
        let mut j = [self.function.constant, 0.0, 0.0, 0.0];
        if let Some(varying) = &self.function.varying {
            let v = place.evaluate(varying, phi).0;
            j.iter_mut().zip(v).for_each(|(j, v)| *j += v);
        }
        for follower in &self.followers {
            let u = place.evaluate(&follower.cam, phi);
            if !follower.linkage.is_empty() {
                j.iter_mut().zip(follower.inertia(u.0)).for_each(|(j, own)| *j += own);
                continue;
            }
            let [_, u1, u2, u3, u4] = u.0;
            j[0] += follower.m * u1 * u1;
            j[1] += 2.0 * follower.m * u1 * u2;
            j[2] += 2.0 * follower.m * (u2 * u2 + u1 * u3);
            j[3] += 2.0 * follower.m * (3.0 * u2 * u3 + u1 * u4);
        }
        j
    }

    /// Only J (kg·m²) at `phi`, continued smoothly from the place `inside`, as steps need it.
    pub fn value(&self, place: Place, phi: f64) -> f64 {
        let phi = into_turn(phi);
        let (sin, cos) = phi.sin_cos();
        let mut j = self.function.constant;
        if let Some(varying) = &self.function.varying {
            j += place.evaluate(varying, phi).0[0];
        }
        for follower in &self.followers {
            if !follower.linkage.is_empty() {
                let [u, u1, ..] = place.evaluate(&follower.cam, phi).0;
                j += follower.inertia([u, u1])[0];
                continue;
            }
            let slope = match follower.cam.series() {
                Some(series) => series.slope(sin, cos),
                None => place.evaluate(&follower.cam, phi).0[1],
            };
            j += follower.m * slope * slope;
        }
        j
    }

    /// The interval between borders that holds `phi` ∈ [−π, π] (rad), and `phi` moved into it by whole turns: interval i reaches
    /// from border i to border i + 1, the last one around the turn. On a border it is the interval ahead.
    pub fn interval(&self, phi: f64, forward: bool) -> (usize, f64) {
        let Some(&first) = self.borders.first() else { return (0, phi) };
        let mut phi = if phi < 0.0 { phi + TAU } else { phi };
        if phi < first {
            phi += TAU;
        }
        let next = self.borders.partition_point(|&b| b <= phi);
        let at_border = (phi - self.borders[next - 1]).abs() <= SAME_BORDER;
        match (at_border && !forward, next - 1) {
            (false, i) => (i, phi),
            (true, 0) => (self.borders.len() - 1, phi + TAU),
            (true, i) => (i - 1, phi),
        }
    }

    /// The ends of interval `i` (rad); infinite without borders.
    pub fn ends(&self, i: usize) -> (f64, f64) {
        if self.borders.is_empty() { (f64::NEG_INFINITY, f64::INFINITY) } else { ends(&self.borders, i) }
    }

    /// The ends of the smooth pieces of the turn (rad); without borders one piece, from 0 on.
    pub fn pieces(&self) -> impl ExactSizeIterator<Item = (f64, f64)> {
        pieces(&self.borders)
    }

    /// The smooth piece of all laws on interval `i`.
    pub fn place(&self, i: usize) -> Place {
        let (low, high) = self.ends(i);
        Place::at(if low.is_finite() { 0.5 * (low + high) } else { 0.0 })
    }

    /// The harmonic order that resolves J(φ): a product of two transfer functions doubles the law's order; the contribution of
    /// mechanisms is measured.
    pub fn resolution(&self) -> f64 {
        let product = self.followers.iter().map(|f| 2.0 * f.cam.resolution());
        let own = self.function.varying.iter().map(|law| law.resolution());
        product.chain(own).chain([self.linked_resolution()]).fold(1.0, f64::max)
    }

    /// A lower bound of J over the turn, from samples and the curvature between them, and the largest sample.
    pub fn range(&self) -> (f64, f64) {
        *self.cache.range.get_or_init(|| self.sampled_range())
    }

    fn sampled_range(&self) -> (f64, f64) {
        // 32 samples per shortest wave leave ½ J″ (Δφ/2)² below half a per cent of that wave's amplitude; the shortest wave of a
        // table is proportional to the distance of its points.
        let count = (32.0 * self.resolution()).clamp(64.0, 65536.0).max(8.0 * self.borders.len() as f64) as usize;
        note(IN_A_ROW * count as f64 * self.cost());
        let step = TAU / count as f64;
        let samples = (0..count).map(|i| {
            let phi = (i as f64 + 0.5) * step;
            self.at(Place::at(phi), phi)
        });
        let (mut low, mut high, mut curvature) = (f64::INFINITY, f64::NEG_INFINITY, 0.0_f64);
        for j in samples {
            low = low.min(j[0]);
            high = high.max(j[0]);
            curvature = curvature.max(j[2].abs());
        }
        let dip = curvature * step * step / 8.0;
        // Followers add nothing negative, so J0 alone is a strict bound. So is the least point of a table that stays within the
        // range of its points.
        let strict = match &self.function.varying {
            None => self.function.constant,
            Some(MotionLaw::Polyline(lines)) => self.function.constant + lines.least(),
            Some(_) => f64::NEG_INFINITY,
        };
        ((low - dip).max(strict), high)
    }
}
