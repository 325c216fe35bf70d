// The smooth works by Runge-Kutta-Fehlberg 7(8) with a fixed step in 80-bit numbers: the truth for benches/peers/compare.py,
// which compares two step lengths.
#include "works.hpp"

#include <array>
#include <boost/numeric/odeint/stepper/runge_kutta_fehlberg78.hpp>

using Long = long double;
using State = std::array<Long, 2>;

template <class Work> static void solve(Work work, long count, int n, double *out, double *rates) {
    boost::numeric::odeint::runge_kutta_fehlberg78<State, Long, State, Long> stepper;
    auto system = [&](const State &y, State &f, Long t) { work(y.data(), f.data(), t); };
    State y = {Work::start[0], Work::start[1]}, f;
    for (long i = 0; i < count; i++) {
        Long begin = works::output_time(i), end = works::output_time(i + 1), h = (end - begin) / n;
        for (int k = 0; k < n; k++) stepper.do_step(system, y, begin + k * h, h);
        system(y, f, end);
        for (int j = 0; j < 2; j++) {
            out[2 * i + j] = double(y[j] * Long(Work::scale[j]));
            rates[2 * i + j] = double(f[j] * Long(Work::scale[j]));
        }
    }
}

// `out` takes the outputs, `rates` their derivatives; n steps per millisecond.
extern "C" int reference(int work, int n, double *out, double *rates) {
    const long count = works::STEPS[work];
    switch (work) {
    case works::M1: solve(works::ElasticOutput<Long>{}, count, n, out, rates); return 0;
    case works::M2: solve(works::ElasticShaft<Long>{}, count, n, out, rates); return 0;
    case works::M4: solve(works::RigidMachine<Long>{}, count, n, out, rates); return 0;
    case works::RAMP: solve(works::Ramp<Long>{}, count, n, out, rates); return 0;
    default: return -1;
    }
}
