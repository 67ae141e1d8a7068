// SPDX-License-Identifier: Apache-2.0
#include "drivers/illuminator/illuminators.hpp"

namespace afterglow {
namespace {

class NoLight final : public Illuminator {
public:
    Status set(bool lit) override {
        lit_ = lit;
        return ok();
    }
    bool lit() const override { return lit_; }
    bool was_lit(std::int64_t /*t_ns*/) const override { return true; }

private:
    bool lit_ = false;
};

} // namespace

std::unique_ptr<Illuminator> open_no_light() {
    return std::make_unique<NoLight>();
}

} // namespace afterglow
