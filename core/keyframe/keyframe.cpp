// SPDX-License-Identifier: Apache-2.0
#include "core/keyframe/keyframe.hpp"

#include "core/base/camera.hpp"
#include "core/surface/sampled_readings.hpp"

#include <algorithm>

namespace afterglow {
namespace {} // namespace

KeyframeSet::KeyframeSet(int capacity, const Views &views, const SurfaceOptions &surface_options,
                         const TemplateOptions &template_options)
    : camera_(views.surface) {
    for (int i = 0; i < capacity; ++i)
        keyframes_.push_back(std::make_unique<Keyframe>(views, surface_options, template_options));
}

// When full, the one that sees least of the present view goes.
Keyframe &KeyframeSet::push(const Pose &current_from_world) {
    const int capacity = static_cast<int>(keyframes_.size());
    int place = size_;
    if (size_ == capacity) {
        float least = 2.0f;
        place = capacity - 1;
        for (int i = 0; i < size_; ++i) {
            Keyframe &k = (*this)[i];
            const Pose pose = current_from_world * k.depth_from_world.inverse();
            // Between views of equal worth the older one goes.
            const float worth =
                visible_share(k.surface, camera_, pose, camera_) - 0.02f * static_cast<float>(i);
            if (worth < least) {
                least = worth;
                place = i;
            }
        }
    } else {
        ++size_;
    }
    std::rotate(keyframes_.begin(), keyframes_.begin() + place, keyframes_.begin() + place + 1);
    return *keyframes_.front();
}

float visible_share(const DepthSurface &surface, const Intrinsics &from, const Pose &pose,
                    const Intrinsics &to) {
    int sampled = 0, visible = 0;
    for_sampled_readings(surface, [&](int u, int v, float z) {
        ++sampled;
        const Eigen::Vector3d Y = pose * from.back_project(u, v, z);
        if (!(Y.z() > nearest_seen_m))
            return;
        const Eigen::Vector2d p = to.project(Y);
        visible += p.x() >= 0 && p.y() >= 0 && p.x() < to.width && p.y() < to.height;
    });
    return sampled ? static_cast<float>(visible) / static_cast<float>(sampled) : 0.0f;
}

float mean_displacement(const DepthSurface &surface, const Intrinsics &camera, const Pose &pose) {
    double sum = 0;
    int count = 0;
    for_sampled_readings(surface, [&](int u, int v, float z) {
        const Eigen::Vector3d Y = pose * camera.back_project(u, v, z);
        if (!(Y.z() > nearest_seen_m))
            return;
        sum += std::min((camera.project(Y) - Eigen::Vector2d(u, v)).norm() / camera.fx, 1.0);
        ++count;
    });
    return count > 0 ? static_cast<float>(sum / count) : 0.0f;
}

} // namespace afterglow
