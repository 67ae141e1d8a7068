// SPDX-License-Identifier: Apache-2.0
#include "drivers/libcamera/camera_id.hpp"
#include "drivers/libcamera/formats.hpp"
#include "tests/catch.hpp"

#include <linux/videodev2.h>

#include <algorithm>
#include <string>
#include <vector>

using namespace afterglow;
using namespace afterglow::libcam;

TEST_CASE("a libcamera camera is chosen by its id or an unambiguous part of it") {
    const std::vector<std::string> ids = {"/base/soc/i2c@1/imx219@10", "/base/soc/i2c@1/imx219@1",
                                          "\\_SB_.PCI0.XHC_-1:1.0-1d6b:0102"};
    CHECK(*choose_id(ids, ids[0]) == ids[0]);
    CHECK(*choose_id(ids, ids[1]) == ids[1]); // though the first has it within
    CHECK(*choose_id(ids, "imx219@10") == ids[0]);
    CHECK(*choose_id(ids, "XHC_") == ids[2]);
    CHECK(choose_id(ids, "imx219").error().message ==
          "the camera 'imx219' may be any of these of libcamera: /base/soc/i2c@1/imx219@10, "
          "/base/soc/i2c@1/imx219@1");
    CHECK(choose_id(ids, "ov5647").error().message ==
          "the camera 'ov5647' is not there (libcamera has /base/soc/i2c@1/imx219@10, "
          "/base/soc/i2c@1/imx219@1, \\_SB_.PCI0.XHC_-1:1.0-1d6b:0102)");
    CHECK(choose_id({}, "ov5647").error().message ==
          "the camera 'ov5647' is not there (libcamera has none)");
}

TEST_CASE("libcamera formats have its codes, with the cheapest luma first") {
    CHECK(drm_code(V4L2_PIX_FMT_GREY) == v4l2_fourcc('R', '8', ' ', ' '));
    CHECK(drm_code(V4L2_PIX_FMT_NV12) == V4L2_PIX_FMT_NV12);
    const std::vector<std::uint32_t> formats = readable_formats();
    for (const std::uint32_t code : formats)
        CHECK(v4l2_code(drm_code(code)) == code);
    const auto place = [&](std::uint32_t code) {
        return std::find(formats.begin(), formats.end(), code) - formats.begin();
    };
    CHECK(place(V4L2_PIX_FMT_GREY) == 0);
    CHECK(place(V4L2_PIX_FMT_NV12) < place(V4L2_PIX_FMT_YUYV));
    CHECK(place(V4L2_PIX_FMT_YUYV) < place(V4L2_PIX_FMT_MJPEG));
    // libv4lconvert's, which want a device of V4L2.
    CHECK(std::find(formats.begin(), formats.end(), V4L2_PIX_FMT_RGB24) == formats.end());
}
