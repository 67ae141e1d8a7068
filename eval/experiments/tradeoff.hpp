// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "eval/experiments/results.hpp"
#include "eval/experiments/sequence.hpp"

#include <cstdint>
#include <functional>
#include <span>
#include <string_view>
#include <vector>

namespace afterglow {

/// Which systems are scored, and at how many settings.
enum class Sweep : std::uint8_t {
    adaptive, ///< This Work and afterglow alone, at all their settings
    matched,  ///< also the others, those with a fixed interval at one duty cycle
    full,     ///< also the others, at several duty cycles
};

/// Scores the systems of systems() on one sequence: first those that decide themselves when to
/// measure, at several settings, and those without a TOF camera; then those with a fixed interval,
/// at compared_duty_cycle() and for a full sweep at other duty cycles.
///
/// Each setting is evaluated by one of `workers` threads. The caller's thread calls `on_score`, in
/// an order that does not depend on the number of threads.
void sweep(const Sequence &sequence, Sweep how, int workers, Watch &watch,
           const std::function<void(Score)> &on_score);

/// The work of that for each frame of a sequence; an estimate.
double sweep_work(Sweep how);

/// The scores of a system on a dataset that have an error and a duty cycle below 100 %.
std::vector<const Score *> scores_of(std::span<const Score> scores, std::string_view dataset,
                                     std::string_view system);

/// As Section V-C of the paper sets thresholds, for a median MRE of about 1 %: the darkest setting
/// with no more, or else the one that comes nearest. Null where there is none.
const Score *tuned_score(std::span<const Score> scores, std::string_view dataset,
                         std::string_view system);
/// The duty cycle, percent, at which the systems are compared on a dataset: that of afterglow's
/// tuned_score(); where afterglow has none, of the paper's system. Negative without either.
double compared_duty_cycle(std::span<const Score> scores, std::string_view dataset);
/// The duty cycles differ by no more than a quarter of the lesser, so that errors may be compared.
bool is_near(double duty_cycle, double other);
/// The setting whose duty cycle is nearest to compared_duty_cycle(); null where there is none.
const Score *matched_score(std::span<const Score> scores, std::string_view dataset,
                           std::string_view system);
/// The system with its default, own_setting(). Null where there is none.
const Score *preset_score(std::span<const Score> scores, std::string_view dataset,
                          std::string_view system);

} // namespace afterglow
