// SPDX-License-Identifier: Apache-2.0
#include "tools/ctl/calibration/rig_files.hpp"

#include "config/calibration_limits.hpp"
#include "core/base/printable.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <filesystem>

namespace afterglow {
namespace {

/// A camera of all files.
struct Candidate {
    const FoundCalibration *file;
    const FoundCamera *camera;

    bool is(const std::string &name) const {
        return camera->name == name || file->path == name ||
               std::filesystem::path(file->path).filename() == name;
    }
};

std::vector<Candidate> candidates_of(const std::vector<FoundCalibration> &files) {
    std::vector<Candidate> candidates;
    for (const FoundCalibration &file : files)
        for (const FoundCamera &camera : file.cameras)
            candidates.push_back({&file, &camera});
    return candidates;
}

std::string list(const std::vector<Candidate> &candidates) {
    std::vector<std::string> names;
    for (const auto &[file, camera] : candidates)
        names.push_back(printable(camera->name.empty() ? file->path : camera->name));
    return fmt::format("{}", fmt::join(names, ", "));
}

/// The camera that somebody has named. Errors: there is none, or several.
Result<const Candidate *> named(const std::vector<Candidate> &candidates, const std::string &name) {
    const Candidate *found = nullptr;
    for (const Candidate &candidate : candidates) {
        if (!candidate.is(name))
            continue;
        if (found != nullptr)
            return Error{fmt::format("several cameras are \"{}\" (there are {})", printable(name),
                                     list(candidates)),
                         EINVAL};
        found = &candidate;
    }
    if (found == nullptr)
        return Error{
            fmt::format("no camera is \"{}\" (there are {})", printable(name), list(candidates)),
            ENOENT};
    return found;
}

struct Roles {
    const Candidate *color = nullptr;
    const Candidate *tof = nullptr;
};

Result<Roles> roles_of(const std::vector<Candidate> &candidates, const RigFiles &files) {
    Roles roles;
    for (const auto &[name, role] :
         {std::pair(&files.color, &roles.color), {&files.tof, &roles.tof}}) {
        if (name->empty())
            continue;
        const Result<const Candidate *> found = named(candidates, *name);
        if (!found)
            return found.error();
        *role = *found;
    }
    if (roles.color != nullptr && roles.color == roles.tof)
        return Error{fmt::format("\"{}\" and \"{}\" are one camera", printable(files.color),
                                 printable(files.tof)),
                     EINVAL};
    if (candidates.size() > 2 && (roles.color == nullptr || roles.tof == nullptr))
        return Error{fmt::format("there are {} cameras, {}: say with --color and --tof which to "
                                 "take",
                                 candidates.size(), list(candidates)),
                     EINVAL};
    for (const Candidate &candidate : candidates) {
        if (roles.color == nullptr && &candidate != roles.tof)
            roles.color = &candidate;
        else if (roles.tof == nullptr && &candidate != roles.color)
            roles.tof = &candidate;
    }
    return roles;
}

Result<FoundCamera> sized(const Candidate &candidate, const std::string &size, const char *option) {
    FoundCamera camera = *candidate.camera;
    if (camera.size_line != 0)
        return camera;
    int &width = camera.model.pinhole.width;
    int &height = camera.model.pinhole.height;
    const char *end = size.data() + size.size();
    const auto [cross, wrong_width] = std::from_chars(size.data(), end, width);
    const bool crossed = wrong_width == std::errc() && cross != end && *cross == 'x';
    if (!crossed || std::from_chars(cross + 1, end, height).ptr != end || height == 0)
        return Error{fmt::format("{}:{}: no image size is told for this camera (give it with {} "
                                 "WIDTHxHEIGHT)",
                                 printable(candidate.file->path), camera.matrix_line, option),
                     EINVAL};
    const Status checked = check_camera(camera, candidate.file->path);
    return checked ? Result<FoundCamera>(camera) : checked.error();
}

/// Of both cameras in one file, or as the one file says that does.
Result<std::optional<Pose>> pose_of(const Roles &roles,
                                    const std::vector<FoundCalibration> &files) {
    const FoundCamera &color = *roles.color->camera;
    const FoundCamera &tof = *roles.tof->camera;
    if (roles.color->file == roles.tof->file && color.pose && tof.pose)
        return std::optional(*tof.pose * color.pose->inverse());
    std::optional<Pose> pose;
    for (const FoundCalibration &file : files) {
        if (!file.second_from_first)
            continue;
        if (pose)
            return Error{"several files say where the cameras are to each other", EINVAL};
        // The first of the cameras in the order of files.
        pose = roles.color < roles.tof ? file.second_from_first
                                       : std::optional(file.second_from_first->inverse());
    }
    return pose;
}

/// `files` says which camera is which.
Result<PartialRig> put_together(const std::vector<FoundCalibration> &found, const RigFiles &files) {
    const std::vector<Candidate> candidates = candidates_of(found);
    if (candidates.empty())
        return Error{"no file has a camera", EINVAL};
    const Result<Roles> roles = roles_of(candidates, files);
    if (!roles)
        return roles.error();
    PartialRig rig;
    if (roles->color != nullptr) {
        const Result<FoundCamera> color = sized(*roles->color, files.color_size, "--color-size");
        if (!color)
            return color.error();
        rig.color = *color;
    }
    if (roles->tof != nullptr) {
        const Result<FoundCamera> tof = sized(*roles->tof, files.tof_size, "--tof-size");
        if (!tof)
            return tof.error();
        rig.tof = *tof;
    }
    if (rig.color && rig.tof) {
        const Result<std::optional<Pose>> pose = pose_of(*roles, found);
        if (!pose)
            return pose.error();
        rig.tof_from_color = *pose;
        if (files.invert && rig.tof_from_color)
            rig.tof_from_color = rig.tof_from_color->inverse();
    }
    return rig;
}

} // namespace

Result<PartialRig> read_rig(const RigFiles &files) {
    std::vector<FoundCalibration> found;
    for (const std::string &path : files.paths) {
        Result<FoundCalibration> calibration = read_calibration(path, files.hints);
        if (!calibration)
            return calibration.error();
        found.push_back(*std::move(calibration));
    }
    return put_together(found, files);
}

Result<PartialRig> parse_rig(const std::string &text, const std::string &path) {
    Result<FoundCalibration> calibration = parse_found_calibration(text, path, {});
    if (!calibration)
        return calibration.error();
    return put_together({*std::move(calibration)}, {});
}

double delay_s(const PartialRig &rig) {
    return rig.tof->clock_shift_s - rig.color->clock_shift_s;
}

Result<RigCalibration> whole(const PartialRig &rig) {
    if (!rig.color || !rig.tof)
        return Error{"there is only one camera (a rig has two: name the other one's file, too)",
                     EINVAL};
    if (!rig.tof_from_color)
        return Error{"no file says where the cameras are to each other (name one with R and T)",
                     EINVAL};
    RigCalibration calibration{rig.color->model, rig.tof->model, *rig.tof_from_color};
    calibration.range_along_ray = rig.tof->range_along_ray;
    calibration.tof_delay_s = delay_s(rig);
    calibration.readout_s = rig.color->readout_s;
    if (const auto problem = problem_of(calibration))
        return Error{fmt::format("{}: {}{}", problem->key, problem->sentence,
                                 problem->key == "translation_m"
                                     ? "; --translation-unit mm is for files in millimetres"
                                     : ""),
                     EINVAL};
    return calibration;
}

} // namespace afterglow
