// The statue is the zero set of one field: a body of ellipsoids and cones joined smoothly, and a
// cloth around its lower half whose folds displace the field.
#include "scenes/statue.h"

#include <algorithm>
#include <cmath>

#include "scenes/surface_nets.h"

namespace sheen::scenes {
namespace {

// Smooth minimum: the two surfaces meet in a fillet about `k` wide.
double blend(double a, double b, double k) {
    const double h = std::max(k - std::abs(a - b), 0.0) / k;
    return std::min(a, b) - h * h * h * k / 6.0;
}

// The first without the second, the edge rounded by about `k`.
double carve(double a, double b, double k) { return -blend(-a, b, k); }

double ellipsoid(const dvec3& p, const dvec3& center, const dvec3& radii) {
    const dvec3 q = p - center;
    const double k0 = glm::length(q / radii);
    const double k1 = glm::length(q / (radii * radii));
    return k1 > 1e-9 ? k0 * (k0 - 1.0) / k1 : -std::min({radii.x, radii.y, radii.z});
}

// A cone with round ends: radius ra at a, rb at b (a linear blend of radii, not an exact distance).
double cone(const dvec3& p, const dvec3& a, const dvec3& b, double ra, double rb) {
    const dvec3 ab = b - a;
    const double t = std::clamp(glm::dot(p - a, ab) / glm::dot(ab, ab), 0.0, 1.0);
    return glm::length(p - a - t * ab) - glm::mix(ra, rb, t);
}

double smoothStep(double lower, double upper, double x) {
    const double t = std::clamp((x - lower) / (upper - lower), 0.0, 1.0);
    return t * t * (3.0 - 2.0 * t);
}

// A bump of height 1 and half width `width` around `center`.
double bump(double x, double center, double width) {
    return std::exp(-(x - center) * (x - center) / (width * width));
}

// A fold's section with period 2 pi, in [-1, 1]: broad round ridges and narrow valleys.
double fold(double t) {
    const double s = std::sin(0.5 * t);
    return 1.0 - 2.0 * std::pow(1.0 - std::sqrt(s * s + 0.03) / 1.015, 1.4);
}

dvec3 turnedAboutY(const dvec3& p, double angle) {
    const double c = std::cos(angle);
    const double s = std::sin(angle);
    return {c * p.x - s * p.z, p.y, s * p.x + c * p.z};
}

// The base is closed a little below the floor it stands on.
constexpr double kSunk = 0.02;

constexpr dvec3 kHeadCenter(0.022, 1.60, 0.010);
constexpr double kHeadTurn = 0.35;  // she looks to her left

double face(const dvec3& q) {
    double d = ellipsoid(q, {0, 0.03, -0.012}, {0.072, 0.088, 0.092});
    d = blend(d, ellipsoid(q, {0, -0.035, 0.030}, {0.056, 0.078, 0.060}), 0.05);
    d = blend(d, ellipsoid(q, {0, -0.088, 0.058}, {0.022, 0.020, 0.020}), 0.03);  // chin
    d = blend(d, ellipsoid(q, {0, 0.022, 0.070}, {0.050, 0.012, 0.014}), 0.03);   // brow
    for (const double side : {-1.0, 1.0}) {
        d = blend(d, ellipsoid(q, {side * 0.036, -0.030, 0.060}, {0.020, 0.018, 0.016}), 0.03);
        d = carve(d, ellipsoid(q, {side * 0.028, 0.002, 0.090}, {0.017, 0.010, 0.014}), 0.012);
        d = blend(d, ellipsoid(q, {side * 0.028, 0.001, 0.070}, {0.012, 0.008, 0.010}), 0.006);
    }
    d = blend(d, cone(q, {0, 0.020, 0.078}, {0, -0.026, 0.092}, 0.0075, 0.0105), 0.016);  // nose
    d = blend(d, ellipsoid(q, {0, -0.052, 0.084}, {0.020, 0.0055, 0.010}), 0.008);        // lips
    d = blend(d, ellipsoid(q, {0, -0.064, 0.081}, {0.017, 0.0060, 0.010}), 0.008);
    return d;
}

// Wavy hair drawn back from a parting into a knot.
double hair(const dvec3& q) {
    const double across = std::atan2(q.y - 0.02, std::abs(q.x) + 1e-3);
    const double back = std::atan2(-q.z + 0.05, std::abs(q.x) + 1e-3);
    const double waves = 0.0045 * std::sin(9.0 * back + 1.5 * std::sin(3.0 * across)) *
                         smoothStep(0.006, 0.03, std::abs(q.x));
    double d = ellipsoid(q, {0, 0.042, -0.022}, {0.086, 0.088, 0.098}) - waves;
    d += 0.005 * bump(q.x, 0.0, 0.012);  // parting
    // The hair line: in front of this plane there is face.
    const double line = (q.z - 0.048) * 0.80 + (0.050 - q.y) * 0.62 - 0.12 * std::abs(q.x);
    d = std::max(d, line);
    const dvec3 knot = q - dvec3(0, 0.035, -0.125);
    const double swirl =
        0.004 * std::sin(2.0 * std::atan2(knot.y, knot.x) + 90.0 * glm::length(knot));
    d = blend(d, ellipsoid(knot, dvec3(0), {0.044, 0.042, 0.040}) - swirl, 0.02);
    return d;
}

double head(const dvec3& p) {
    const dvec3 q = turnedAboutY(p - kHeadCenter, kHeadTurn);
    return blend(face(q), hair(q), 0.008);
}

double arms(const dvec3& p) {
    // Broken off above the elbow and below the shoulder; the breaks are flat and tilted.
    double right = cone(p, {-0.178, 1.345, -0.015}, {-0.232, 1.06, 0.015}, 0.056, 0.043);
    right = std::max(
        right, glm::dot(p - dvec3(-0.222, 1.125, 0.0), glm::normalize(dvec3(-0.10, -1.0, 0.25))));
    double left = cone(p, {0.172, 1.372, -0.015}, {0.31, 1.26, 0.06}, 0.054, 0.046);
    left = std::max(left,
                    glm::dot(p - dvec3(0.243, 1.317, 0.02), glm::normalize(dvec3(0.9, -0.5, 0.3))));
    return std::min(right, left);
}

double torso(const dvec3& p) {
    double d = ellipsoid(p, {0.004, 1.235, -0.012}, {0.142, 0.165, 0.100});           // ribs
    d = blend(d, ellipsoid(p, {-0.004, 1.045, 0.000}, {0.112, 0.150, 0.086}), 0.08);  // waist
    d = blend(d, ellipsoid(p, {-0.010, 0.955, 0.022}, {0.128, 0.105, 0.096}), 0.07);  // belly
    d = blend(d, ellipsoid(p, {-0.016, 0.885, -0.010}, {0.172, 0.125, 0.118}), 0.07);
    for (const double side : {-1.0, 1.0}) {
        d = blend(d, ellipsoid(p, {-0.016 + side * 0.078, 0.865, -0.075}, {0.088, 0.100, 0.078}),
                  0.05);
        const double lift = side > 0.0 ? 0.010 : 0.0;
        d = blend(d,
                  ellipsoid(p, {0.006 + side * 0.066, 1.232 + lift, 0.066}, {0.053, 0.058, 0.048}),
                  0.050);
    }
    // Shoulders: her right is lower.
    d = blend(d, cone(p, {-0.155, 1.352, -0.018}, {0.160, 1.380, -0.018}, 0.056, 0.054), 0.06);
    d = blend(d, cone(p, {-0.08, 1.385, -0.030}, {0.010, 1.455, -0.010}, 0.040, 0.040), 0.07);
    d = blend(d, cone(p, {0.10, 1.398, -0.030}, {0.020, 1.455, -0.010}, 0.040, 0.040), 0.07);
    d = blend(d, arms(p), 0.035);
    d = blend(d, cone(p, {0.008, 1.395, -0.012}, {0.022, 1.545, 0.004}, 0.058, 0.051), 0.045);
    // Collar bones, the furrow of the belly and of the back, the navel.
    d = blend(d, cone(p, {0.020, 1.393, 0.052}, {0.125, 1.412, 0.022}, 0.008, 0.008), 0.022);
    d = blend(d, cone(p, {-0.006, 1.391, 0.052}, {-0.115, 1.386, 0.022}, 0.008, 0.008), 0.022);
    d += 0.006 * bump(p.x, 0.0, 0.016) * smoothStep(0.93, 1.0, p.y) *
         (1.0 - smoothStep(1.12, 1.2, p.y));
    d += 0.010 * bump(p.x, 0.0, 0.020) * (1.0 - smoothStep(-0.06, -0.02, p.z)) *
         smoothStep(0.88, 0.98, p.y) * (1.0 - smoothStep(1.28, 1.40, p.y));
    return carve(d, ellipsoid(p, {-0.004, 0.985, 0.118}, {0.010, 0.012, 0.016}), 0.012);
}

// The legs under the cloth: she stands on the right one; the left knee comes forward.
double drapedLegs(const dvec3& p) {
    const double right = cone(p, {-0.088, 0.83, -0.005}, {-0.100, 0.12, -0.02}, 0.120, 0.088);
    const double thigh = cone(p, {0.078, 0.82, 0.005}, {0.108, 0.535, 0.125}, 0.118, 0.078);
    const double shin = cone(p, {0.108, 0.535, 0.125}, {0.150, 0.10, 0.02}, 0.076, 0.070);
    double d = blend(right, blend(thigh, shin, 0.09), 0.13);
    // Between and behind the legs the cloth falls nearly straight, widening to the hem.
    d = blend(d, cone(p, {0.000, 0.78, 0.020}, {0.020, 0.08, 0.010}, 0.128, 0.192), 0.08);
    return d;
}

double foldsOfSkirt(const dvec3& p) {
    const double down = 0.90 - p.y;  // from the hips
    const double phi = std::atan2(p.x - 0.025, p.z + 0.02);
    // From her left knee (phi about 0.6) the folds fan out: there the cloth is taut.
    const double knee =
        std::exp(-((phi - 0.72) * (phi - 0.72) / 0.16 + (p.y - 0.53) * (p.y - 0.53) / 0.08));
    const double thigh_front = bump(phi, -0.62, 0.30) * bump(p.y, 0.62, 0.20);
    const double depth = 0.0135 * smoothStep(0.0, 0.30, down) * (0.7 + 1.0 * down) *
                         (1.0 - 0.90 * std::min(1.0, knee + 0.75 * thigh_front));
    const double sway =
        0.9 * std::sin(2.0 * phi + 2.2 * down) + 0.30 * std::sin(5.0 * phi + 6.0 * p.y);
    const double long_folds = fold(14.0 * phi + 2.4 * down * std::sin(phi - 0.7) + 1.4 * sway);
    const double short_folds = 0.30 * fold(27.0 * phi - 3.1 * down + 2.0 * sway + 1.3);
    // Pulled from the right hip across to the left knee.
    const double cross_folds = 0.0055 * bump(phi, -0.1, 0.6) * bump(p.y, 0.72, 0.09) *
                               fold(70.0 * (p.y + 0.45 * (p.x + 0.10)) + 0.6 * sway);
    return depth * (long_folds + short_folds) + cross_folds;
}

// The cloth rolled around the hips, tilted, twisted like a rope.
double roll(const dvec3& p) {
    const double phi = std::atan2(p.x + 0.012, p.z + 0.010);
    const dvec2 out = glm::normalize(dvec2(p.x + 0.012, p.z + 0.010) + dvec2(1e-9));
    const dvec3 ring(-0.012 + 0.158 * out.x,
                     0.858 + 0.030 * std::sin(phi + 2.2) + 0.018 * std::sin(2.0 * phi),
                     -0.010 + 0.126 * out.y);
    const dvec3 q = p - ring;
    const double along = glm::dot(dvec2(q.x, q.z), out);
    const double turn = std::atan2(q.y, along);
    const double tube = glm::length(dvec2(along, 0.80 * q.y));
    return tube - 0.036 - 0.0075 * fold(4.0 * turn + 11.0 * phi) -
           0.006 * std::sin(3.0 * phi + 0.5);
}

// The end of the cloth, hanging in front between the legs.
double hangingEnd(const dvec3& p) {
    const double down = std::clamp((0.86 - p.y) / 0.74, 0.0, 1.0);
    const double center_x = -0.035 + 0.030 * down;
    const double width = 0.028 + 0.040 * down;
    const double x = (p.x - center_x) / width;
    const double z = 0.128 + 0.016 * std::sin(2.6 * down) + 0.012 * std::cos(6.0 * x + 2.0 * down) +
                     0.035 * down;
    const double slab = glm::length(dvec2(std::max(std::abs(x) - 1.0, 0.0) * width,
                                          std::max(std::abs(p.z - z) - 0.012, 0.0))) -
                        0.010;
    return std::max(slab, std::max(p.y - 0.85, 0.10 + 0.03 * std::sin(5.0 * x) - p.y));
}

double feet(const dvec3& p) {
    double d = 1.0;
    for (const double side : {-1.0, 1.0}) {
        const dvec3 heel(side < 0.0 ? -0.105 : 0.150, 0.105, side < 0.0 ? 0.03 : 0.06);
        const dvec3 ball = heel + dvec3(side * 0.025, -0.022, 0.115);
        const double toes =
            0.002 * std::cos(190.0 * (p.x - ball.x)) * smoothStep(0.0, 0.05, p.z - ball.z);
        d = std::min(
            d,
            blend(cone(p, heel, ball, 0.044, 0.026),
                  ellipsoid(p, ball + dvec3(side * 0.004, 0, 0.02), {0.044, 0.022, 0.060}), 0.03) +
                toes);
    }
    return d;
}

// A rough-hewn round base with a flat top.
double base(const dvec3& p) {
    const double radius = 0.300 + 0.006 * std::sin(5.0 * std::atan2(p.x, p.z)) +
                          0.003 * std::sin(60.0 * p.y + 9.0 * std::atan2(p.x, p.z));
    const double side = glm::length(dvec2(p.x - 0.02, p.z - 0.02)) - radius;
    const double top = p.y - 0.065;
    return -blend(-side, -top, 0.02);
}

double statueField(const dvec3& p) {
    double skirt = drapedLegs(p);
    if (skirt < 0.12) {
        skirt -= foldsOfSkirt(p);
    }
    // The skirt ends at the hips and just above the base.
    skirt = std::max(skirt, p.y - 0.90);
    double cloth = blend(skirt, hangingEnd(p), 0.06);
    cloth = blend(cloth, roll(p), 0.012);
    double d = blend(torso(p), head(p), 0.02);
    d = std::min(d, std::max(feet(p), p.y - 0.2));
    d = blend(d, cloth, 0.006);
    d = blend(d, base(p), 0.010);
    return std::max(d, -kSunk - p.y);
}

}  // namespace

Mesh statue() {
    const Grid grid = {
        .x = borders(-0.40, 0.42, [](double x) { return std::abs(x) < 0.1 ? 0.0135 : 0.0175; }),
        .y = borders(-0.05, 1.80,
                     [](double y) { return y > 1.48   ? 0.0098
                                           : y > 0.80 ? 0.0168
                                                      : 0.0235; }),
        .z = borders(-0.40, 0.42, [](double z) { return z < -0.1 ? 0.0165 : 0.0150; })};
    return polygonize(statueField, grid);
}

}  // namespace sheen::scenes
