// SPDX-License-Identifier: Apache-2.0
//
// camera.txt of a recording: whatever camera it claims, both pipelines give numbers for it.
#include "core/pipeline.hpp"
#include "drivers/files/recording.hpp"
#include "tests/fuzz/require.hpp"
#include "tests/temporary_folder.hpp"

#include <cmath>

using namespace afterglow;

namespace {

constexpr int most_pixels = 64 * 64; // of a camera that is tried: more only take longer

void check(const Estimate &e) {
    require(e.pose.is_finite(), "a pose is finite");
    require((e.pose.R * e.pose.R.transpose() - Eigen::Matrix3d::Identity()).norm() < 1e-6,
            "a rotation is one");
    require(std::isfinite(e.expected_mre), "the expected error is finite");
    require(e.coverage >= 0 && e.coverage <= 100, "coverage is a share");
    require(e.inliers >= 0 && e.inliers <= e.matches, "inliers are among the matches");
    for (int v = 0; v < e.depth.height(); ++v)
        for (int u = 0; u < e.depth.width(); ++u)
            require((e.depth(u, v) != 0) == (e.confidence(u, v) != 0),
                    "confidence is where depth is");
}

/// A texture, moved by `shift` pixels.
Luma image(const Intrinsics &camera, int shift) {
    Luma luma(camera.width, camera.height);
    for (int v = 0; v < camera.height; ++v)
        for (int u = 0; u < camera.width; ++u)
            luma(u, v) = static_cast<std::uint8_t>((u + shift) * 37 ^ v * 11);
    return luma;
}

/// A slope with holes.
DepthMap depth(const Intrinsics &camera) {
    DepthMap map(camera.width, camera.height);
    for (int v = 0; v < camera.height; ++v)
        for (int u = 0; u < camera.width; ++u)
            map(u, v) = static_cast<std::uint16_t>((u * 7 + v * 3) % 11 == 0 ? 0 : 900 + 13 * u);
    return map;
}

void estimate(const Intrinsics &camera, Method method) {
    static WorkerPool pool(1);
    const auto pipeline = pipeline_factory({.method = method}, pool)(camera);
    for (int frame = 0; frame < 4; ++frame) {
        check(pipeline->track(image(camera, frame), frame * 33'333'333l));
        if (frame % 2 == 0)
            check(pipeline->measure(depth(camera)));
    }
}

} // namespace

extern "C" int LLVMFuzzerTestOneInput(const char *data, std::size_t size) {
    static const TemporaryFolder folder;
    folder.write("camera.txt", {data, size});
    const Result<RecordingCamera> camera = read_recording_camera(folder.path());
    if (!camera) {
        require(camera.error().message.starts_with(folder.path()), "an error names the file");
        return 0;
    }
    if (camera->intrinsics.width * camera->intrinsics.height <= most_pixels) {
        estimate(camera->intrinsics, Method::keyframe);
        estimate(camera->intrinsics, Method::paper);
    }
    return 0;
}
