// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "core/base/views.hpp"
#include "core/rig/rig_geometry.hpp"

namespace afterglow {

/// Whether the colour camera and the published one see something of what the TOF camera sees,
/// between 0.3 and 10 m. Their lenses must show rays.
bool views_meet(const RigGeometry &geometry);

/// The pinhole cameras to work in for two cameras with lenses: each at the place of its camera and
/// looking the same way, with no more of the view than the TOF camera sees and a margin for what
/// has just left it.
///
/// Sizes: the tracking camera is at most 640 pixels wide and not finer than the colour camera.
/// Where the colour camera is published, its view is composed there. Other published views are not
/// finer than the published camera, nor than twice the TOF camera, nor wider than 640 pixels unless
/// the TOF camera is. Measured maps come as fine as composed ones. views_meet() must hold.
Views working_views(const RigGeometry &geometry);

} // namespace afterglow
