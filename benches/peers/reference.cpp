// The works by Runge-Kutta-Fehlberg 7(8) with a fixed step in 80-bit numbers, M6 with the events in them: the truth for
// benches/peers/compare.py, which compares two step lengths. (M3 is chaotic: it has closed forms in 40 digits instead.)
#include "peer.hpp"

#include <array>
#include <boost/numeric/odeint/stepper/runge_kutta_fehlberg78.hpp>

using Long = long double;

template <int N> struct Stepper {
    using State = std::array<Long, N>;
    boost::numeric::odeint::runge_kutta_fehlberg78<State, Long, State, Long> stepper;

    template <class System> void step(const System &system, Long t, const Long *y, Long h, Long *into) {
        State z;
        std::copy(y, y + N, z.begin());
        stepper.do_step([&](const State &y, State &f, Long t) { system(y.data(), f.data(), t); }, z, t, h);
        std::copy(z.begin(), z.end(), into);
    }
};

template <class Work> static void solve(Work work, long count, int n, double *out, double *rates) {
    Stepper<Work::N> stepper;
    Long y[Work::N], f[Work::N];
    work.start(y);
    for (long i = 0; i < count; i++) {
        Long begin = works::output_time(i), end = works::output_time(i + 1), h = (end - begin) / n;
        for (int k = 0; k < n; k++) stepper.step(work, begin + k * h, y, h, y);
        work(y, f, end);
        for (int j = 0; j < 2; j++) {
            out[2 * i + j] = double(y[Work::output[j]] * Long(Work::scale[j]));
            rates[2 * i + j] = double(f[Work::output[j]] * Long(Work::scale[j]));
        }
    }
}

template <class Drive> struct Fixed {
    Stepper<Drive::BOUND> bound;
    Stepper<Drive::LOOSE> loose;

    template <int N, class System> Long advance(System &system, Long t, Long *y, Long limit) {
        single<N>(system, t, y, limit - t, y);
        return limit;
    }
    template <int N, class System> void single(System &system, Long t, const Long *y, Long h, Long *into) {
        if constexpr (N == Drive::BOUND) bound.step(system, t, y, h, into);
        else loose.step(system, t, y, h, into);
    }
    void restart() {}
};

template <class Drive> static int solve_drive(Drive drive, long count, int n, double *out, double *rates) {
    using Run = peer::BacklashRun<Drive, Fixed<Drive>, Long>;
    Run run(drive, Fixed<Drive>());
    for (long i = 0; i < count; i++) {
        Long begin = works::output_time(i), end = works::output_time(i + 1), both[2];
        for (int k = 1; k <= n; k++)
            if (!run.reach(k < n ? begin + k * (end - begin) / n : end)) return -1;
        run.drive.outputs(run.y, run.t, run.flank, both);
        std::copy(both, both + 2, out + 2 * i);
        run.drive.output_rates(run.y, run.t, run.flank, both);
        std::copy(both, both + 2, rates + 2 * i);
    }
    return 0;
}

// `out` takes the outputs, `rates` their derivatives; n steps per millisecond.
extern "C" int reference(int work, int n, double *out, double *rates) {
    const long count = works::STEPS[work];
    switch (work) {
    case works::M1: solve(works::ElasticOutput<Long>{}, count, n, out, rates); return 0;
    case works::M2: solve(works::ElasticShaft<Long>{}, count, n, out, rates); return 0;
    case works::M4: solve(works::RigidMachine<Long>{}, count, n, out, rates); return 0;
    case works::RAMP: solve(works::Ramp<Long>{}, count, n, out, rates); return 0;
    case works::M5: solve(works::Train<Long>{}, count, n, out, rates); return 0;
    case works::M6: return solve_drive(works::TrainBacklash<Long>{}, count, n, out, rates);
    default: return -1;
    }
}
