// SPDX-License-Identifier: Apache-2.0
#include "drivers/simulated/synthetic/surface.hpp"

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>

namespace afterglow {
namespace {

/// What is nearer than this, or behind the camera, is not seen; metres.
constexpr double nearest = 0.01;
constexpr double furthest = 1000;

/// n.d as a function of the pixel that the ray d goes through.
LinearInPixel dot_with_ray(const Eigen::Vector3d &n, const Intrinsics &camera) {
    const double a = n.x() / camera.fx;
    const double b = n.y() / camera.fy;
    return {a, b, n.z() - a * camera.cx - b * camera.cy};
}

LinearInPixel combine(const LinearInPixel &x, double factor, const LinearInPixel &y) {
    return {x.a + factor * y.a, x.b + factor * y.b, x.c + factor * y.c};
}

std::uint8_t to_luma(int fixed) {
    return static_cast<std::uint8_t>(std::clamp((fixed + 128) >> 8, 0, 255));
}

/// An interval of columns that shrinks with each condition.
class Interval {
public:
    explicit Interval(int width) : low_(0), high_(width - 1) {}

    /// Keeps the u where a u + c >= 0.
    void keep(double a, double c) {
        if (a > 0)
            low_ = std::max(low_, -c / a);
        else if (a < 0)
            high_ = std::min(high_, -c / a);
        else if (c < 0)
            high_ = low_ - 1;
    }
    bool empty() const { return !(low_ <= high_); }
    Columns columns() const {
        if (empty())
            return {};
        return {static_cast<int>(std::ceil(low_)), static_cast<int>(std::floor(high_)) + 1};
    }

private:
    double low_, high_;
};

} // namespace

PlaneView::PlaneView(const Quad &quad, const Texture &texture, const Pose &body_to_camera,
                     const Intrinsics &camera)
    : texture_(&texture), offset_s_(static_cast<float>(quad.texture_offset.x())),
      offset_t_(static_cast<float>(quad.texture_offset.y())),
      brightness_(static_cast<int>(std::lround(256 * quad.brightness))) {
    const Eigen::Vector3d o = body_to_camera * quad.corner;
    const Eigen::Vector3d r = body_to_camera.R * quad.right;
    const Eigen::Vector3d e = body_to_camera.R * quad.down;
    const Eigen::Vector3d n = r.cross(e); // away from whoever sees the front
    const double distance = n.dot(o);
    normal_ = -n;
    faces_camera_ = distance > 1e-6;
    if (!faces_camera_)
        return;
    inverse_z_ = dot_with_ray(n / distance, camera);
    s_over_z_ = combine(dot_with_ray(r, camera), -r.dot(o), inverse_z_);
    t_over_z_ = combine(dot_with_ray(e, camera), -e.dot(o), inverse_z_);
    // 0 <= s <= width, 0 <= t <= height and nearest <= z <= furthest, each over z.
    seen_where_ = {s_over_z_,
                   t_over_z_,
                   combine({0, 0, 0}, -1, combine(s_over_z_, -quad.width, inverse_z_)),
                   combine({0, 0, 0}, -1, combine(t_over_z_, -quad.height, inverse_z_)),
                   combine({0, 0, 1 / nearest}, -1, inverse_z_),
                   combine({0, 0, -1 / furthest}, 1, inverse_z_)};
}

Columns PlaneView::columns(int v, int width) const {
    Interval interval(width);
    for (const LinearInPixel &condition : seen_where_) {
        interval.keep(condition.a, condition.b * v + condition.c);
        if (interval.empty())
            return {};
    }
    return interval.columns();
}

double PlaneView::inverse_z_if_seen(double u, double v) const {
    for (const LinearInPixel &condition : seen_where_) {
        if (condition(u, v) < 0)
            return 0;
    }
    return inverse_z_(u, v);
}

bool PlaneView::may_be_in(const Box &box) const {
    return std::ranges::all_of(
        seen_where_, [&](const LinearInPixel &condition) { return condition.highest(box) >= 0; });
}

bool PlaneView::fills(const Box &box) const {
    return std::ranges::all_of(
        seen_where_, [&](const LinearInPixel &condition) { return condition.lowest(box) >= 0; });
}

float PlaneView::level(double u, double v) const {
    const double z = 1 / inverse_z_(u, v);
    const double s = s_over_z_(u, v) * z;
    const double t = t_over_z_(u, v) * z;
    // Derivatives of s = (s/z) / (1/z), and of t, over u and v; the longer way decides.
    const auto squared_length = [&](double ds, double dt) { return ds * ds + dt * dt; };
    const double along_u =
        squared_length(s_over_z_.a - s * inverse_z_.a, t_over_z_.a - t * inverse_z_.a);
    const double along_v =
        squared_length(s_over_z_.b - s * inverse_z_.b, t_over_z_.b - t * inverse_z_.b);
    const double scale = z * static_cast<double>(Texture::texels_per_metre);
    return std::log2(static_cast<float>(std::max(along_u, along_v) * scale * scale)) / 2;
}

int PlaneView::luma(double u, double v, float level_shift) const {
    const double z = 1 / inverse_z_(u, v);
    const auto s = static_cast<float>(s_over_z_(u, v) * z);
    const auto t = static_cast<float>(t_over_z_(u, v) * z);
    return texture_->sample(s + offset_s_, t + offset_t_, level(u, v) + level_shift) *
               brightness_ >>
           8;
}

void PlaneView::shade(const Places &places, float *z, std::uint8_t *luma) const {
    const std::size_t count = places.u.size();
    // The level changes slowly: exact at both ends, linear between.
    const float level_begin = level(places.u[0], places.v[0]) + places.level[0];
    const float level_end =
        level(places.u[count - 1], places.v[count - 1]) + places.level[count - 1];
    const float level_step = (level_end - level_begin) / static_cast<float>(count);
    for (std::size_t i = 0; i < count; ++i) {
        const double u = places.u[i], v = places.v[i];
        const double depth = 1 / inverse_z_(u, v);
        const int fixed = texture_->sample(static_cast<float>(s_over_z_(u, v) * depth) + offset_s_,
                                           static_cast<float>(t_over_z_(u, v) * depth) + offset_t_,
                                           level_begin + static_cast<float>(i) * level_step);
        z[i] = static_cast<float>(depth);
        luma[i] = to_luma(fixed * brightness_ >> 8);
    }
}

void PlaneView::shade(int u, int v, std::span<const float> inverse_z, float *z,
                      std::uint8_t *luma) const {
    // The level changes slowly: exact at every 16th pixel, linear between.
    constexpr std::size_t stretch = 16;
    const auto s_step = static_cast<float>(s_over_z_.a);
    const auto t_step = static_cast<float>(t_over_z_.a);
    float level_here = level(u, v);
    for (std::size_t begin = 0; begin < inverse_z.size(); begin += stretch) {
        const std::size_t length = std::min(stretch, inverse_z.size() - begin);
        const int at = u + static_cast<int>(begin);
        const float level_next = level(at + static_cast<int>(length) - 1, v);
        const float level_step = (level_next - level_here) / static_cast<float>(length);
        const auto s_begin = static_cast<float>(s_over_z_(at, v));
        const auto t_begin = static_cast<float>(t_over_z_(at, v));
        for (std::size_t i = 0; i < length; ++i) {
            const auto along = static_cast<float>(i);
            const float depth = 1 / inverse_z[begin + i];
            const int fixed = texture_->sample((s_begin + along * s_step) * depth + offset_s_,
                                               (t_begin + along * t_step) * depth + offset_t_,
                                               level_here + along * level_step);
            z[begin + i] = depth;
            luma[begin + i] = to_luma(fixed * brightness_ >> 8);
        }
        level_here = level_next;
    }
}

BallView::BallView(const Sphere &sphere, const Texture &texture, const Pose &body_to_camera,
                   const Intrinsics &camera)
    : texture_(&texture), camera_(camera), center_(body_to_camera * sphere.center),
      radius_(sphere.radius), to_body_(body_to_camera.R.transpose()),
      brightness_(sphere.brightness) {}

Eigen::Vector3d BallView::ray(double u, double v) const {
    return camera_.back_project(u, v, 1);
}

bool BallView::is_ahead() const {
    return center_.z() >= radius_ + nearest;
}

Columns BallView::columns(int v, int width) const {
    // The ray d meets the sphere where (d.c)^2 - d.d (c.c - r^2) >= 0: a quadratic in x.
    const Eigen::Vector3d &c = center_;
    if (!is_ahead())
        return {};
    const double y = ray(0, v).y();
    const double k = c.squaredNorm() - radius_ * radius_;
    const double rest = c.y() * y + c.z();
    const double p = c.x() * c.x() - k;
    const double q = c.x() * rest;
    const double w = rest * rest - k * (y * y + 1);
    const double discriminant = q * q - p * w;
    if (p >= 0 || discriminant < 0)
        return {};
    const double root = std::sqrt(discriminant);
    const double x_low = (-q + root) / p;
    const double x_high = (-q - root) / p;
    Interval interval(width);
    interval.keep(1, -(x_low * camera_.fx + camera_.cx));
    interval.keep(-1, x_high * camera_.fx + camera_.cx);
    return interval.columns();
}

double BallView::inverse_z_if_seen(double u, double v) const {
    if (!is_ahead())
        return 0;
    const Eigen::Vector3d d = ray(u, v);
    const double along = d.dot(center_);
    const double k = center_.squaredNorm() - radius_ * radius_;
    const double discriminant = along * along - d.squaredNorm() * k;
    if (discriminant < 0 || along <= 0)
        return 0;
    return (along + std::sqrt(discriminant)) / k; // 1 / ((along - root) / d.d)
}

bool BallView::may_be_in(const Box &box) const {
    if (!is_ahead())
        return false;
    // The tangents from the camera to its outline in the planes y = 0 and x = 0.
    const auto reaches = [&](double c, double f, double centre, double at, double half) {
        const double z = center_.z();
        const double p = z * z - radius_ * radius_;
        const double root = radius_ * std::sqrt(c * c + p);
        return (c * z + root) / p * f + centre >= at - half &&
               (c * z - root) / p * f + centre <= at + half;
    };
    return reaches(center_.x(), camera_.fx, camera_.cx, box.u, box.half_width) &&
           reaches(center_.y(), camera_.fy, camera_.cy, box.v, box.half_height);
}

Eigen::Vector3d BallView::normal(double u, double v) const {
    const double inverse_z = inverse_z_if_seen(u, v);
    return inverse_z > 0 ? Eigen::Vector3d((ray(u, v) / inverse_z - center_) / radius_)
                         : Eigen::Vector3d(-ray(u, v).normalized());
}

int BallView::luma(double u, double v, float level_shift) const {
    const double inverse_z = inverse_z_if_seen(u, v);
    if (inverse_z <= 0) // by rounding, on its outline
        return 0;
    const double z = 1 / inverse_z;
    const Eigen::Vector3d d = ray(u, v);
    const Eigen::Vector3d normal = (z * d - center_) / radius_;
    // The pattern is laid on from the six sides of a cube around the sphere.
    const Eigen::Vector3d n = to_body_ * normal;
    int side = 0;
    const double longest = n.cwiseAbs().maxCoeff(&side);
    const auto s = static_cast<float>(n[(side + 1) % 3] / longest * radius_ + radius_);
    const auto t = static_cast<float>(n[(side + 2) % 3] / longest * radius_ + radius_);
    const double slant = std::max(0.1, -normal.dot(d.normalized()));
    const double footprint = z / camera_.fx / (slant * longest);
    const float level =
        std::log2(static_cast<float>(footprint) * Texture::texels_per_metre) + level_shift;
    // Lit from above, a little from everywhere.
    const double light = brightness_ * (0.75 - 0.35 * normal.y());
    return static_cast<int>(texture_->sample(s, t, level) * light);
}

} // namespace afterglow
