// The works of the benchmarks as ordinary differential equations, the same numbers as in benches/works/*.toml.
//
// States are scaled so that they and their errors are of the order of one: a scalar tolerance then means the same for
// every component and every peer. The position functions cost one sine and one cosine; harmonics 3 and 5 are
// polynomials of these. The compared outputs are states, or in contact the place of the flank.
#pragma once

#include <cmath>

namespace works {

constexpr double TURN = 6.283185307179586;

enum Work { M1, M2, M3, M4, RAMP, M5, M6, WORKS };

// Outputs are read every millisecond.
constexpr long STEPS[WORKS] = {12500, 33333, 10000, 10000, 10000, 10000, 10000};

inline double output_time(long i) { return double(i) * 1e-3; }

// U', U'', U''' of U = sum A_k cos k phi, k = 1, 3, 5, from sin phi and cos phi.
template <class R> struct Law {
    R a1, a3, a5;

    explicit Law(R stroke) : a1(R(0.59404) * stroke), a3(R(-0.11066) * stroke), a5(R(0.01667) * stroke) {}

    R u0(R c) const {
        R c2 = c * c;
        return c * (a1 + a3 * (4 * c2 - 3) + a5 * ((16 * c2 - 20) * c2 + 5));
    }
    R u1(R s) const {
        R s2 = s * s;
        return -s * (a1 + 3 * a3 * (3 - 4 * s2) + 5 * a5 * ((16 * s2 - 20) * s2 + 5));
    }
    R u2(R c) const {
        R c2 = c * c;
        return -c * (a1 + 9 * a3 * (4 * c2 - 3) + 25 * a5 * ((16 * c2 - 20) * c2 + 5));
    }
    R u3(R s) const {
        R s2 = s * s;
        return s * (a1 + 27 * a3 * (3 - 4 * s2) + 125 * a5 * ((16 * s2 - 20) * s2 + 5));
    }
};

// q'' + 2 D w0 q' + w0^2 q = -x''; y = (q / Q, q' / (Q w0)).
template <class R> struct ElasticOutput {
    static constexpr double Q = 1e-4;
    static constexpr double W0 = 376.99111843077515;
    static constexpr int N = 2;
    static constexpr int output[2] = {0, 1};
    static constexpr double scale[2] = {Q, Q * W0};
    static void start(R *y) { y[0] = y[1] = 0; }
    // The scene gives c and b, rounded to double.
    R c = R(142122.30337568672), b = R(15.079644737231007), w = R(50.26548245743669);
    Law<R> law{R(0.01)};

    void operator()(const R *y, R *f, R t) const {
        R acceleration = law.u2(std::cos(w * t)) * w * w;
        respond(y, f, acceleration);
    }
    void respond(const R *y, R *f, R acceleration) const {
        f[0] = R(W0) * y[1];
        f[1] = -b * y[1] - c / R(W0) * y[0] - acceleration / R(Q * W0);
    }
    static constexpr double corner = 0.0;
};

// The same with a speed that rises to w within 5 s and stays.
template <class R> struct Ramp : ElasticOutput<R> {
    static constexpr double corner = 5.0;
    R rate = this->w / 5;

    void operator()(const R *y, R *f, R t) const {
        R phi, speed, alpha;
        if (t <= R(corner)) {
            phi = rate * t * t / 2, speed = rate * t, alpha = rate;
        } else {
            phi = this->w * (t - R(corner) / 2), speed = this->w, alpha = 0;
        }
        R s = std::sin(phi), c = std::cos(phi);
        this->respond(y, f, this->law.u2(c) * speed * speed + this->law.u1(s) * alpha);
    }
};

// (J + m U'^2) q'' + (b + 2 m w U'U'') q' + (c + m w^2 (U''^2 + U'U''')) q = -m w^2 U'U''; y = (q / Q, q' / (Q w0)).
template <class R> struct ElasticShaft {
    static constexpr double Q = 0.1, W0 = 200.0;
    static constexpr int N = 2;
    static constexpr int output[2] = {0, 1};
    static constexpr double scale[2] = {Q, Q * W0};
    static void start(R *y) { y[0] = y[1] = 0; }
    static constexpr double corner = 0.0;
    R m = 20, J = R(0.05), c = 2000, b = R(0.6), w = R(18.84955592153876);
    Law<R> law{R(0.1)};

    void operator()(const R *y, R *f, R t) const {
        R sine = std::sin(w * t), cosine = std::cos(w * t);
        R u1 = law.u1(sine), u2 = law.u2(cosine), u3 = law.u3(sine);
        R mw = m * w, g = mw * u1 * u2, stiffness = c + mw * w * (u2 * u2 + u1 * u3);
        f[0] = R(W0) * y[1];
        f[1] = -(g * w / R(Q * W0) + (b + 2 * g) * y[1] + stiffness / R(W0) * y[0]) / (J + m * u1 * u1);
    }
};

// J phi'' + J' phi'^2 / 2 = M, Kloss; the second follower 90 degrees later.
template <class R> struct RigidMachine {
    static constexpr int N = 2;
    static constexpr int output[2] = {0, 1};
    static constexpr double scale[2] = {1.0, 1.0};
    static void start(R *y) { y[0] = 0, y[1] = R(0.5); }
    static constexpr double corner = 0.0;
    R J0 = R(0.5), m1 = 30, m2 = 15, Mk = 60, sk = R(0.12), ws = R(62.83185307179586);
    Law<R> law{R(0.1)};

    void operator()(const R *y, R *f, R) const {
        R s = std::sin(y[0]), c = std::cos(y[0]), w = y[1];
        R p1 = law.u1(s), p2 = law.u2(c);
        // sin(phi - 90 deg) = -cos phi, cos(phi - 90 deg) = sin phi.
        R q1 = law.u1(-c), q2 = law.u2(s);
        R inertia = J0 + m1 * p1 * p1 + m2 * q1 * q1;
        R slip = (ws - w) / ws;
        R torque = 2 * Mk * sk * slip / (slip * slip + sk * sk);
        f[0] = w;
        f[1] = (torque - (m1 * p1 * p2 + m2 * q1 * q2) * w * w) / inertia;
    }
};

// The followers of a train: elastic outputs whose q'' = F / m - U'' phi'^2 - U' phi'' with F = -(c q + b q') takes U' F
// from the shaft.
template <class R> struct Output {
    R m, c, b;
    Law<R> law;
};

// A shaft with a Kloss motor that lags and FOLLOWERS elastic outputs; y = (phi, phi' / W, M / T, then q / Q, q' / (Q W0) of
// each).
template <class R, int FOLLOWERS> struct Shaft {
    static constexpr double W = 60.0, T = 10.0, Q = 1e-3, W0 = 300.0;
    static constexpr int STATES = 3 + 2 * FOLLOWERS;
    static constexpr double W_START = 0.5;
    R J0 = R(0.08), Mk = 12, sk = R(0.15), ws = R(62.83185307179586), lag = R(0.01);
    Output<R> followers[3] = {
        {R(3.0), R(426366.91012706014), R(45.238934211693014), Law<R>(R(0.06))},
        {R(5.0), R(399718.978244119), R(84.82300164692441), Law<R>(R(0.04))},
        {R(1.5), R(378992.80900183134), R(30.159289474462014), Law<R>(R(-0.08))},
    };

    R kloss(R w) const {
        R slip = (ws - w) / ws;
        return 2 * Mk * sk * slip / (slip * slip + sk * sk);
    }
    // The followers are a quarter of a turn apart: the third has the angle of the first and a negative stroke.
    static R sine(int j, R s, R c) { return j == 1 ? -c : s; }
    static R cosine(int j, R s, R c) { return j == 1 ? s : c; }
    // The torque on the shaft without what else is on it.
    R torque(const R *y, R s, R c) const {
        R sum = R(T) * y[2];
        for (int j = 0; j < FOLLOWERS; j++) sum += followers[j].law.u1(sine(j, s, c)) * pull(y, j);
        return sum;
    }
    R pull(const R *y, int j) const {
        return followers[j].c * R(Q) * y[3 + 2 * j] + followers[j].b * R(Q * W0) * y[4 + 2 * j];
    }
    void rates(const R *y, R *f, R s, R c, R acceleration) const {
        R w = R(W) * y[1];
        f[0] = w;
        f[1] = acceleration / R(W);
        f[2] = (kloss(w) / R(T) - y[2]) / lag;
        for (int j = 0; j < FOLLOWERS; j++) {
            const Output<R> &o = followers[j];
            R x2 = o.law.u2(cosine(j, s, c)) * w * w + o.law.u1(sine(j, s, c)) * acceleration;
            f[3 + 2 * j] = R(W0) * y[4 + 2 * j];
            f[4 + 2 * j] = -(pull(y, j) / o.m + x2) / R(Q * W0);
        }
    }
    void start_shaft(R *y) const {
        y[0] = 0;
        y[1] = R(W_START) / R(W);
        y[2] = kloss(R(W_START)) / R(T);
        for (int j = 0; j < FOLLOWERS; j++) {
            // At rest relative to the cam.
            y[3 + 2 * j] = y[4 + 2 * j] = 0;
        }
    }
};

template <class R> struct Train : Shaft<R, 3> {
    using Base = Shaft<R, 3>;
    static constexpr int N = Base::STATES;
    static constexpr int output[2] = {1, 3};
    static constexpr double scale[2] = {Base::W, Base::Q};
    static constexpr double corner = 0.0;

    void start(R *y) const { this->start_shaft(y); }
    void operator()(const R *y, R *f, R) const {
        R s = std::sin(y[0]), c = std::cos(y[0]);
        this->rates(y, f, s, c, this->torque(y, s, c) / this->J0);
    }
};

// The drives with backlash have BOUND states while m1 is on flank A (1) or B (-1), and LOOSE, the last two of them x1 and
// x1', between the flanks (0). `force` is sigma F_K, positive while the flank pushes, `gap` the clearance to a flank.
// `impact` puts m1 on the flank it hits, with its impulse, and says whether it stays.

// The drive with backlash, undamped; b = e = 0. y = (x2, v2 / W, x1, v1 / W) / X.
template <class R> struct Backlash {
    static constexpr double X = 0.01, W = 251.32741228718345;
    static constexpr int BOUND = 2, LOOSE = 4, WORK = M3;
    R m1 = 2, m2 = 8, c = R(505323.74533577514), s = R(1e-4), w = R(31.41592653589793);
    Law<R> law{R(0.02)};
    R k1 = c / m1 / R(W), k2 = c / m2 / R(W);

    void contact(const R *y, R *f, R t, int flank) const {
        f[0] = R(W) * y[1];
        f[1] = k2 * (flank_position(t, flank) / R(X) - y[0]);
    }
    void free(const R *y, R *f) const {
        R q = y[0] - y[2];
        f[0] = R(W) * y[1];
        f[1] = -k2 * q;
        f[2] = R(W) * y[3];
        f[3] = k1 * q;
    }
    R force(const R *y, R t, int flank) const {
        R cosine = std::cos(w * t);
        R x1 = law.u0(cosine) + (flank > 0 ? R(0) : s);
        return flank * (m1 * law.u2(cosine) * w * w - c * (y[0] * R(X) - x1));
    }
    R gap(const R *y, R t, int flank) const {
        R z = y[2] * R(X) - law.u0(std::cos(w * t));
        return flank > 0 ? z : s - z;
    }
    R flank_position(R t, int flank) const { return law.u0(std::cos(w * t)) + (flank > 0 ? R(0) : s); }
    void on_flank(R *y, R t, int flank) const {
        y[2] = flank_position(t, flank) / R(X);
        y[3] = law.u1(std::sin(w * t)) * w / R(X * W);
    }
    bool impact(R *y, R t, int flank) const {
        on_flank(y, t, flank);
        return force(y, t, flank) > 0;
    }
    int start(R *y) const {
        const int flank = law.u2(R(1)) < 0 ? -1 : 1;
        on_flank(y, R(0), flank);
        y[0] = y[2], y[1] = y[3];
        return flank;
    }
    void outputs(const R *y, R t, int flank, R *out) const {
        out[0] = flank ? flank_position(t, flank) : y[2] * R(X);
        out[1] = y[0] * R(X);
    }
};

// The train with a clearance in its third follower; e = 0. y = (the shaft and two outputs, x2 / X, v2 / V, x1 / X, v1 / V).
template <class R> struct TrainBacklash : Shaft<R, 2> {
    using Base = Shaft<R, 2>;
    static constexpr double X = 0.04, V = 20.0;
    static constexpr int BOUND = Base::STATES + 2, LOOSE = BOUND + 2, WORK = M6;
    R m1 = R(0.5), m2 = R(1.5), k = R(378992.80900183134), d = R(75.39822368615505), clearance = R(1e-4);
    Law<R> law{R(-0.08)};

    R flank_position(R c, int flank) const { return law.u0(c) + (flank > 0 ? R(0) : clearance); }
    // S0, the force of m1 on m2.
    R spring(const R *y, R x1, R v1) const {
        return k * (x1 - R(X) * y[BOUND - 2]) + d * (v1 - R(V) * y[BOUND - 1]);
    }
    void rates_with(const R *y, R *f, R s, R c, R acceleration, R spring) const {
        this->rates(y, f, s, c, acceleration);
        f[BOUND - 2] = R(V / X) * y[BOUND - 1];
        f[BOUND - 1] = spring / (m2 * R(V));
    }
    void contact(const R *y, R *f, R, int flank) const {
        R s = std::sin(y[0]), c = std::cos(y[0]), w = R(Base::W) * y[1], u1 = law.u1(s), u2 = law.u2(c);
        R S = spring(y, flank_position(c, flank), u1 * w);
        R torque = this->torque(y, s, c) - u1 * (S + m1 * u2 * w * w);
        rates_with(y, f, s, c, torque / (this->J0 + m1 * u1 * u1), S);
    }
    void free(const R *y, R *f) const {
        R s = std::sin(y[0]), c = std::cos(y[0]);
        R S = spring(y, R(X) * y[BOUND], R(V) * y[BOUND + 1]);
        rates_with(y, f, s, c, this->torque(y, s, c) / this->J0, S);
        f[BOUND] = R(V / X) * y[BOUND + 1];
        f[BOUND + 1] = -S / (m1 * R(V));
    }
    R force(const R *y, R, int flank) const {
        R s = std::sin(y[0]), c = std::cos(y[0]), w = R(Base::W) * y[1], u1 = law.u1(s), u2 = law.u2(c);
        R S = spring(y, flank_position(c, flank), u1 * w);
        R alone = this->torque(y, s, c) / this->J0;
        return flank * (m1 * (u2 * w * w + u1 * alone) + S) / (1 + m1 * u1 * u1 / this->J0);
    }
    R gap(const R *y, R, int flank) const {
        R z = R(X) * y[BOUND] - law.u0(std::cos(y[0]));
        return flank > 0 ? z : clearance - z;
    }
    void on_flank(R *y, R, int flank) const {
        y[BOUND] = flank_position(std::cos(y[0]), flank) / R(X);
        y[BOUND + 1] = law.u1(std::sin(y[0])) * R(Base::W) * y[1] / R(V);
    }
    // The speed of the shaft jumps, and with it those of the outputs relative to their cams.
    bool impact(R *y, R t, int flank) const {
        R s = std::sin(y[0]), c = std::cos(y[0]), u1 = law.u1(s);
        R approach = R(V) * y[BOUND + 1] - u1 * R(Base::W) * y[1];
        R jump = u1 * approach / (1 / m1 + u1 * u1 / this->J0) / this->J0;
        y[1] += jump / R(Base::W);
        for (int j = 0; j < 2; j++)
            y[4 + 2 * j] -= this->followers[j].law.u1(this->sine(j, s, c)) * jump / R(Base::Q * Base::W0);
        on_flank(y, t, flank);
        return force(y, t, flank) > 0;
    }
    int start(R *y) const {
        this->start_shaft(y);
        for (int flank : {1, -1}) {
            on_flank(y, R(0), flank);
            y[BOUND - 2] = y[BOUND], y[BOUND - 1] = y[BOUND + 1];
            if (force(y, R(0), flank) > 0) return flank;
        }
        return 0;
    }
    void outputs(const R *y, R, int flank, R *out) const {
        out[0] = flank ? flank_position(std::cos(y[0]), flank) : R(X) * y[BOUND];
        out[1] = R(X) * y[BOUND - 2];
    }
    void output_rates(const R *y, R, int flank, R *out) const {
        out[0] = flank ? law.u1(std::sin(y[0])) * R(Base::W) * y[1] : R(V) * y[BOUND + 1];
        out[1] = R(V) * y[BOUND - 1];
    }
};

}  // namespace works
