// SPDX-License-Identifier: Apache-2.0
#include "core/moving/residual_flow.hpp"

#include "core/moving/image_patch.hpp"
#include "core/moving/motion_mask.hpp"

#include <algorithm>
#include <array>
#include <limits>
#include <utility>

namespace afterglow {
namespace {

/// From the first pixel of a patch to that of the next, pixels of the level.
constexpr int stride = ImagePatch::side / 2;
/// The first patch's gradients need a pixel before it.
constexpr int border = 1;
/// The level has at most so many columns.
constexpr int most_columns = 200;
/// Patches are searched for in moving cells and so many cells around.
constexpr int reach_cells = 1;
constexpr int most_steps = 6;
/// Gauss-Newton steps from flows that are nearer to each other than this end at one place; pixels
/// of the level.
constexpr float alike = 0.25f;
/// Refinement ends at a step that is shorter, or longer, than these; pixels of the level.
constexpr float least_step = 0.03f, longest_step = 4;
/// A patch that differs by less than this has not moved: root mean square, grey values; multiplied
/// by the keyframe's contrast.
constexpr float same_grey = 3;
/// A patch moves if its flow leaves less than this share of the mean square difference.
constexpr float most_left = 0.25f;
/// The keyframe does not show what is at a pixel whose surroundings (claim_pixels()) differ by more
/// than this in every patch: mean absolute difference, grey values; multiplied by the keyframe's
/// contrast.
constexpr float unlike_grey = 12;

/// The difference of a pixel that no patch has claimed.
constexpr float nothing_claimed = std::numeric_limits<float>::max();

int patches_along(int pixels) {
    return std::max(0, (pixels - 2 * border - ImagePatch::side) / stride + 1);
}
int first_pixel(int patch) {
    return border + patch * stride;
}
/// The first of so many patches that begins at a pixel or behind it.
int first_patch_from(int pixel, int patches) {
    return std::clamp((pixel - border + stride - 1) / stride, 0, patches);
}

} // namespace

int ResidualFlow::level_for(const Intrinsics &tracking, int most_level) {
    int level = 1;
    while (level < most_level && tracking.width >> level > most_columns &&
           MotionMask::cell_px >> level > 1)
        ++level;
    return level;
}

ResidualFlow::ResidualFlow(const Views &views, int most_level, bool enabled)
    : enabled_(enabled && views.publishes_tracking()),
      level_(level_for(views.tracking, most_level)), camera_(views.tracking.at_level(level_)),
      patches_(patches_along(camera_.width), patches_along(camera_.height)),
      least_(camera_.width, camera_.height), owner_(camera_.width, camera_.height),
      shifts_(views.published.width >> level_, views.published.height >> level_) {}

void ResidualFlow::find(const KeyframeImage &then, const Pyramid &now, const Placement &at,
                        DepthView composed, ImageView<const std::uint8_t> moving) {
    if (then.t_ns != then_ns_) {
        then_ns_ = then.t_ns;
        for (Patch &patch : patches_.pixels())
            patch.moves = false;
    }
    any_ = changed_ = false;
    if (!enabled_) {
        leave_out(moving);
        return;
    }
    const Search in = {then, now.level(level_), {at.gain, at.offset}, at.pose.inverse(), composed};
    if (choose_patches(moving))
        match_patches(in);
    densify(in);
}

void ResidualFlow::match_patches(const Search &in) {
    // A patch tries the flow of its neighbours: from the top left on, then from the bottom right
    // on.
    for (int y = 0; y < patches_.height(); ++y)
        for (int x = 0; x < patches_.width(); ++x)
            if (patches_(x, y).searched)
                match(x, y, in);
    for (int y = patches_.height() - 1; y >= 0; --y)
        for (int x = patches_.width() - 1; x >= 0; --x)
            if (patches_(x, y).searched)
                match_again(x, y, in);
}

/// Marks the patches that touch a moving cell, or one near it, as searched. Returns whether a cell
/// moves.
bool ResidualFlow::choose_patches(ImageView<const std::uint8_t> moving) {
    bool any = false;
    for (Patch &patch : patches_.pixels())
        patch.searched = false;
    const int cell = MotionMask::cell_px >> level_;
    const auto touching = [&](int at, int patches) { // from one, to the one after the last
        const int begin = (at - reach_cells) * cell, end = (at + 1 + reach_cells) * cell;
        return std::array{first_patch_from(begin - ImagePatch::side + 1, patches),
                          first_patch_from(end, patches)};
    };
    for (int y = 0; y < moving.height(); ++y)
        for (int x = 0; x < moving.width(); ++x) {
            if (moving(x, y) == 0)
                continue;
            any = true;
            const auto [left, right] = touching(x, patches_.width());
            const auto [top, bottom] = touching(y, patches_.height());
            for (int j = top; j < bottom; ++j)
                for (int i = left; i < right; ++i)
                    patches_(i, j).searched = true;
        }
    for (Patch &patch : patches_.pixels())
        if (!patch.searched) {
            patch.moves = patch.unlike = false;
            patch.flow = {0, 0};
        }
    return any;
}

/// Where the camera's motion puts, in the keyframe's image, the patch with this first pixel.
Eigen::Vector2f ResidualFlow::place_of(const Eigen::Vector2f &first, const Search &in) const {
    constexpr float to_middle = 0.5f * (ImagePatch::side - 1);
    const Eigen::Vector2f middle = first.array() + to_middle;
    const Eigen::Vector2i pixel =
        ((middle.array() + 0.5f) * static_cast<float>(1 << level_)).cast<int>();
    const int u = std::clamp(pixel.x(), 0, in.composed.width() - 1);
    const int v = std::clamp(pixel.y(), 0, in.composed.height() - 1);
    const Eigen::Vector3d X =
        in.to_then * camera_.back_project(middle.x(), middle.y(), metres_or_far(in.composed, u, v));
    if (!(X.z() > 0))
        return {-1, -1}; // where no picture shows it
    return camera_.project(X).cast<float>().array() - to_middle;
}

/// Finds a patch in the keyframe's image; starts at no flow, at its last and at its neighbours'
/// flow.
void ResidualFlow::match(int x, int y, const Search &in) {
    Patch &patch = patches_(x, y);
    const Eigen::Vector2f before = patch.flow;
    const bool moved = std::exchange(patch.moves, false);
    patch.flow = {0, 0};
    patch.unlike = false;
    const Eigen::Vector2i first = {first_pixel(x), first_pixel(y)};
    patch.place = place_of(first.cast<float>(), in);
    if (!shows_patch(in.then.grey, patch.place))
        return;
    const ImagePatch seen = patch_at(in.now, first.x(), first.y());
    patch.fit = fit_patch(seen, in.then.grey, patch.place, in.brightness);
    patch.still = patch.fit.mean_square;
    const float same = in.then.contrast * same_grey;
    if (patch.still < same * same)
        return;
    patch.unlike = true;
    if (!seen.is_distinct())
        return;
    if (moved)
        try_flow(before, seen, in, patch);
    for (const Patch *neighbour : neighbours(x, y))
        if (differs(patch, *neighbour))
            try_flow(neighbour->flow, seen, in, patch);
    refine(x, y, seen, in);
}

/// Tries the flow of neighbours that were matched after the patch.
void ResidualFlow::match_again(int x, int y, const Search &in) {
    Patch &patch = patches_(x, y);
    if (!patch.moves && !patch.unlike)
        return;
    const auto others = neighbours(x, y);
    if (std::ranges::none_of(others, [&](const Patch *other) { return differs(patch, *other); }))
        return;
    const ImagePatch seen = patch_at(in.now, first_pixel(x), first_pixel(y));
    if (!seen.is_distinct())
        return;
    bool better = false;
    for (const Patch *other : others)
        better = (differs(patch, *other) && try_flow(other->flow, seen, in, patch)) || better;
    if (better)
        refine(x, y, seen, in);
}

/// Whether a neighbour's flow is another one, and so worth trying.
bool ResidualFlow::differs(const Patch &patch, const Patch &neighbour) {
    return neighbour.moves && (neighbour.flow - patch.flow).squaredNorm() > alike * alike;
}

/// At the borders a patch stands for a neighbour that is not there.
std::array<const ResidualFlow::Patch *, 4> ResidualFlow::neighbours(int x, int y) const {
    const int right = std::min(x + 1, patches_.width() - 1);
    const int below = std::min(y + 1, patches_.height() - 1);
    return {&patches_(std::max(x - 1, 0), y), &patches_(x, std::max(y - 1, 0)), &patches_(right, y),
            &patches_(x, below)};
}

/// Takes a flow if the patch differs less there than at the flow that it has.
bool ResidualFlow::try_flow(const Eigen::Vector2f &flow, const ImagePatch &seen, const Search &in,
                            Patch &patch) {
    if (!shows_patch(in.then.grey, patch.place + flow))
        return false;
    const PatchFit fit = fit_patch(seen, in.then.grey, patch.place + flow, in.brightness);
    if (!(fit.mean_square < patch.fit.mean_square))
        return false;
    patch.fit = fit;
    patch.flow = flow;
    return true;
}

/// Improves a patch's flow by Gauss-Newton steps, and decides whether the patch moves.
void ResidualFlow::refine(int x, int y, const ImagePatch &seen, const Search &in) {
    Patch &patch = patches_(x, y);
    for (int i = 0; i < most_steps; ++i) {
        const float length = patch.fit.step.norm();
        if (!(length > least_step && length < longest_step) ||
            !try_flow(patch.flow + patch.fit.step, seen, in, patch))
            break;
    }
    patch.moves = patch.fit.mean_square < most_left * patch.still;
    patch.unlike = !patch.moves;
    if (patch.moves)
        patch.shift = shift_of(patch, x, y, in);
    else
        patch.flow = {0, 0};
}

/// Where the composed map shows what the patch shows. The thing there may be nearer or farther than
/// what the map shows at the patch, so that the camera's motion moves it by another parallax.
ResidualFlow::Shift ResidualFlow::shift_of(const Patch &patch, int x, int y,
                                           const Search &in) const {
    const Eigen::Vector2f first = {static_cast<float>(first_pixel(x)),
                                   static_cast<float>(first_pixel(y))};
    Eigen::Vector2f flow = patch.flow;
    const Eigen::Vector2f found = patch.place + patch.flow;
    const Eigen::Vector2f back = place_of(first + flow, in);
    if (shows_patch(in.then.grey, back))
        flow += found - back;
    const Eigen::Vector2i pixels =
        (static_cast<float>(1 << level_) * flow).array().round().cast<int>();
    return {static_cast<std::int16_t>(pixels.x()), static_cast<std::int16_t>(pixels.y())};
}

/// Gives each pixel the shift of that patch around it which differs least there.
void ResidualFlow::densify(const Search &in) {
    const bool differ = std::ranges::any_of(
        patches_.pixels(), [](const Patch &patch) { return patch.moves || patch.unlike; });
    // Pixels that were displaced in the last image may be no more.
    const Area area = joined(area_, differ ? area_of_patches() : Area{});
    for (int v = area.top; v < area.bottom; ++v) {
        std::fill(least_.row(v) + area.left, least_.row(v) + area.right, nothing_claimed);
        std::fill(owner_.row(v) + area.left, owner_.row(v) + area.right, -1);
    }
    for (int y = 0; differ && y < patches_.height(); ++y)
        for (int x = 0; x < patches_.width(); ++x) {
            const Patch &patch = patches_(x, y);
            if (!patch.searched)
                continue;
            const Eigen::Vector2f place = patch.place + patch.flow;
            if (shows_patch(in.then.grey, place))
                claim_pixels(in.now, first_pixel(x), first_pixel(y), in.then.grey, place,
                             in.brightness, patch.moves ? y * patches_.width() + x : -1, least_,
                             owner_);
        }
    const float unlike = in.then.contrast * unlike_grey;
    for (int v = area.top; v < area.bottom; ++v)
        for (int u = area.left; u < area.right; ++u) {
            const float difference = least_(u, v);
            const std::int32_t owner = owner_(u, v);
            Shift shift;
            if (difference > unlike && difference < nothing_claimed)
                shift = Shift::nowhere();
            else if (owner >= 0)
                shift = patches_.pixels()[static_cast<std::size_t>(owner)].shift;
            any_ = any_ || shift != Shift{};
            changed_ = changed_ || shift != shifts_(u, v);
            shifts_(u, v) = shift;
        }
    area_ = differ ? area : Area{};
}

/// All pixels of moving cells get their depth from nowhere.
void ResidualFlow::leave_out(ImageView<const std::uint8_t> moving) {
    const int cell = MotionMask::cell_px >> level_;
    for (int top = 0; top < shifts_.height(); top += cell)
        for (int left = 0; left < shifts_.width(); left += cell) {
            const bool moves = moving(left / cell, top / cell) != 0;
            const Shift shift = moves ? Shift::nowhere() : Shift{};
            any_ = any_ || moves;
            if (shifts_(left, top) == shift)
                continue;
            changed_ = true;
            for (int v = top; v < std::min(top + cell, shifts_.height()); ++v)
                std::fill_n(shifts_.row(v) + left, std::min(cell, shifts_.width() - left), shift);
        }
}

/// The pixels of all patches that were looked for.
ResidualFlow::Area ResidualFlow::area_of_patches() const {
    Area area;
    for (int y = 0; y < patches_.height(); ++y)
        for (int x = 0; x < patches_.width(); ++x)
            if (patches_(x, y).searched)
                area =
                    joined(area, {first_pixel(x), first_pixel(y), first_pixel(x) + ImagePatch::side,
                                  first_pixel(y) + ImagePatch::side});
    return area;
}

ResidualFlow::Area ResidualFlow::joined(const Area &a, const Area &b) {
    if (a.left == a.right || b.left == b.right) // one is empty
        return a.left == a.right ? b : a;
    return {std::min(a.left, b.left), std::min(a.top, b.top), std::max(a.right, b.right),
            std::max(a.bottom, b.bottom)};
}

} // namespace afterglow
