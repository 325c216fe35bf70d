// The works of the benchmarks as ordinary differential equations, the same numbers as in benches/works/*.toml.
//
// States are scaled so that they and their errors are of the order of one: a scalar tolerance then means the same for
// every component and every peer. The position functions cost one sine and one cosine; harmonics 3 and 5 are
// polynomials of these.
#pragma once

#include <cmath>

namespace works {

constexpr double TURN = 6.283185307179586;

enum Work { M1, M2, M3, M4, RAMP, WORKS };

// Outputs are read every millisecond.
constexpr long STEPS[WORKS] = {12500, 33333, 10000, 10000, 10000};

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
    static constexpr double scale[2] = {Q, Q * W0};
    static constexpr double start[2] = {0.0, 0.0};
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
    static constexpr double scale[2] = {Q, Q * W0};
    static constexpr double start[2] = {0.0, 0.0};
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
    static constexpr double scale[2] = {1.0, 1.0};
    static constexpr double start[2] = {0.0, 0.5};
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

// The drive with backlash, undamped; b = e = 0. y = (x2, v2 / W) / X in contact, (x2, v2 / W, x1, v1 / W) / X between
// the flanks.
struct Backlash {
    static constexpr double X = 0.01, W = 251.32741228718345;
    double m1 = 2.0, m2 = 8.0, c = 505323.74533577514, s = 1e-4, w = 31.41592653589793;
    Law<double> law{0.02};
    double k1 = c / m1 / W, k2 = c / m2 / W;

    void contact(const double *y, double *f, double t, int flank) const {
        double x1 = (law.u0(std::cos(w * t)) + (flank > 0 ? 0.0 : s)) / X;
        f[0] = W * y[1];
        f[1] = k2 * (x1 - y[0]);
    }
    void free(const double *y, double *f) const {
        double q = y[0] - y[2];
        f[0] = W * y[1];
        f[1] = -k2 * q;
        f[2] = W * y[3];
        f[3] = k1 * q;
    }
    // sigma F_K: positive while the flank pushes.
    double force(const double *y, double t, int flank) const {
        double cosine = std::cos(w * t);
        double x1 = law.u0(cosine) + (flank > 0 ? 0.0 : s);
        return flank * (m1 * law.u2(cosine) * w * w - c * (y[0] * X - x1));
    }
    // The clearance to flank A (x1 - U) or B (U + s - x1).
    double gap(const double *y, double t, int flank) const {
        double z = y[2] * X - law.u0(std::cos(w * t));
        return flank > 0 ? z : s - z;
    }
    double flank_position(double t, int flank) const { return law.u0(std::cos(w * t)) + (flank > 0 ? 0.0 : s); }
    double flank_speed(double t) const { return law.u1(std::sin(w * t)) * w; }
    void start(double *y, int *flank) const {
        *flank = law.u2(1.0) < 0.0 ? -1 : 1;
        y[0] = flank_position(0.0, *flank) / X;
        y[1] = flank_speed(0.0) / (X * W);
    }
};

}  // namespace works
