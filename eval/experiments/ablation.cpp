// SPDX-License-Identifier: Apache-2.0
#include "eval/experiments/ablation.hpp"

#include "eval/ablate.hpp"
#include "eval/experiments/jobs.hpp"
#include "eval/experiments/run_system.hpp"

#include <cassert>
#include <optional>

namespace afterglow {
namespace {

Tuned tuned(const Variant &variant) {
    const auto resolved = TuningArguments{.assignments = variant.assignments}.resolve();
    assert(resolved); // they are our own
    return {resolved->first, resolved->second};
}

} // namespace

std::vector<Ablation> ablate_sequence(const Sequence &sequence, int workers, Watch &watch) {
    const SystemDescription &system = *find_system("default");
    const auto &variants = ablation_variants();
    std::vector<std::optional<Ablation>> done(variants.size());
    run_jobs(variants.size(), workers, [&](std::size_t i) {
        WorkerPool alone(1);
        const Tuned made = tuned(variants[i]);
        if (const auto evaluation = run_system(sequence, system, made, alone, watch))
            done[i] = {std::string(variants[i].name), std::string(variants[i].shows),
                       summarize(*evaluation, sequence.name, std::string(system.name),
                                 made.gate.target_mre)};
    });
    std::vector<Ablation> all;
    for (auto &ablation : done) {
        if (!ablation)
            return {};
        all.push_back(*std::move(ablation));
    }
    return all;
}

double ablation_work() {
    return static_cast<double>(ablation_variants().size()) * work_of(*find_system("default"));
}

} // namespace afterglow
