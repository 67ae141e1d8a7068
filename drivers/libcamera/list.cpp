// SPDX-License-Identifier: Apache-2.0
#include "core/base/printable.hpp"
#include "drivers/libcamera/helper_process.hpp"
#include "drivers/libcamera/libcamera.hpp"
#include "drivers/v4l2/device.hpp"

#include <cerrno>
#include <sstream>

namespace afterglow {
namespace {

using namespace libcam;

constexpr auto time_to_list = std::chrono::seconds(5);

} // namespace

Result<std::vector<LibcameraListing>> list_libcamera_cameras(const std::string &helper) {
    const auto deadline = std::chrono::steady_clock::now() + time_to_list;
    const Result<HelperProcess> process = HelperProcess::start(helper, {"list"});
    if (!process)
        return process.error();
    std::vector<LibcameraListing> listings;
    Report report;
    std::vector<UniqueFd> descriptors;
    for (;;) {
        switch (process->await(report, descriptors, deadline)) {
        case Received::nothing:
            return Error{"libcamera does not say which cameras it has", ETIMEDOUT};
        case Received::end:
            return Error{"libcamera's process ended", EIO};
        case Received::message:
            break;
        }
        if (report.kind == Report::Kind::failed)
            return Error{printable(report.text.data()), report.code};
        if (report.kind == Report::Kind::done)
            return listings;
        if (report.kind == Report::Kind::camera) {
            std::istringstream lines(report.text.data());
            LibcameraListing &listing = listings.emplace_back();
            std::getline(lines, listing.id);
            std::getline(lines, listing.model);
        } else if (report.kind == Report::Kind::mode && !listings.empty()) {
            listings.back().modes.push_back(
                {v4l2::to_string(report.fourcc), report.width, report.height, 0, false});
        }
    }
}

} // namespace afterglow
