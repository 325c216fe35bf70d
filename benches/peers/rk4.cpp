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

template <class System> struct Smooth final : peer::Run {
    System system;
    long n;
    double t = 0.0, y[System::N];

    Smooth(const System &s, long steps) : system(s), n(steps) { system.start(y); }
    bool advance(double end, double *out) override {
        const double begin = t, h = (end - t) / double(n);
        for (long k = 0; k < n; k++) step<System::N>(system, begin + double(k) * h, y, h, y);
        t = end;
        peer::put<System>(out, y);
        return true;
    }
};

}  // namespace

const char *const peer::METHODS = "RK4, fixed step";

std::unique_ptr<peer::Run> peer::start(int, int work, double setting) {
    const long n = long(setting);
    auto run = with_work(work, [&](auto system) { return std::make_unique<Smooth<decltype(system)>>(system, n); });
    if (run) return run;
    return with_drive(work, [&](auto drive) {
        return std::make_unique<BacklashRun<decltype(drive), Fixed>>(drive, Fixed{1e-3 / double(n)});
    });
}
