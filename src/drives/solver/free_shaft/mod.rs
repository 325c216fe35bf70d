//! The motion of a free shaft. Two modules integrate it in turns:
//!
//! | | while | internal steps |
//! |---|---|---|
//! | `in_angle` | torques do not depend on time, no lag, and the shaft turns fast | as the tolerance allows; they go on beyond communication points |
//! | `in_time` | else: a torque that changes with time, a motor with a lag, standstill, reversal | as the tolerance allows; they end at communication points |
//! | `in_time` on its `grid` | `solver.method` = `fixed_cost` | equal ones; they go on beyond communication points while torques stay as they are |
//!
//! Each of them **begins** at a state with the errors so far, **extends** the motion by an internal step, is **read** at a time
//! within that step and **left** at the time of the last reading. The start on a periodic motion is in `steady`.

mod angle_step;
mod angle_steps;
mod cycle;
pub(in crate::drives) mod grid;
pub(in crate::drives) mod in_angle;
pub(in crate::drives) mod in_time;
pub mod lagging_turn;
pub(in crate::drives) mod mesh;
pub(in crate::drives) mod steady;
pub mod turn_map;
