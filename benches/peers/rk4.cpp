// The classical fourth-order method of Runge and Kutta with a fixed step: what a modeller writes by hand.
#include "peer.hpp"

namespace {

template <int N, class System> void step(System &system, double t, const double *y, double h, double *into) {
    double k1[N], k2[N], k3[N], k4[N], z[N];
    system(y, k1, t);
    for (int i = 0; i < N; i++) z[i] = y[i] + 0.5 * h * k1[i];
    system(z, k2, t + 0.5 * h);
    for (int i = 0; i < N; i++) z[i] = y[i] + 0.5 * h * k2[i];
    system(z, k3, t + 0.5 * h);
    for (int i = 0; i < N; i++) z[i] = y[i] + h * k3[i];
    system(z, k4, t + h);
    for (int i = 0; i < N; i++) into[i] = y[i] + h / 6.0 * (k1[i] + 2.0 * (k2[i] + k3[i]) + k4[i]);
}

struct Fixed {
    double h;
    template <int N, class System> double advance(System &system, double t, double *y, double limit) {
        // The last step of a millisecond ends on it; a remainder of rounding is not a step.
        double end = t + h < limit - 1e-3 * h ? t + h : limit;
        step<N>(system, t, y, end - t, y);
        return end;
    }
    template <int N, class System> void single(System &system, double t, const double *y, double h, double *into) {
        step<N>(system, t, y, h, into);
    }
    void restart() {}
};

}  // namespace

const char *peer_methods() { return "RK4, fixed step"; }

int peer_solve(int, int work, double setting, double *out, double *cpu_seconds) {
    const long n = long(setting);
    peer::Clock clock;
    int result;
    if (work == works::M3) {
        Fixed method{1e-3 / double(n)};
        result = peer::BacklashRun<Fixed>(method).run(out);
    } else {
        result = peer::with_work(work, [&](auto system) {
            using Work = decltype(system);
            double y[2] = {Work::start[0], Work::start[1]};
            const double h = 1e-3 / double(n);
            for (long i = 0; i < works::STEPS[work]; i++) {
                const double begin = works::output_time(i);
                for (long k = 0; k < n; k++) step<2>(system, begin + double(k) * h, y, h, y);
                peer::put<Work>(out, i, y);
            }
            return 0;
        });
    }
    *cpu_seconds = clock.seconds();
    return result;
}
