// SPDX-License-Identifier: Apache-2.0
#include "core/alignment/weighted_products.hpp"
#include "tests/catch.hpp"
#include "tests/instruction_set.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <random>
#include <vector>

using namespace afterglow;

TEST_CASE("weighted products of columns are summed as one by one", "[core]") {
    AFTERGLOW_ON_EACH_INSTRUCTION_SET();
    constexpr int blocks = 3;
    const int rows = GENERATE(64, 192, 512);
    std::mt19937 random(8);
    std::normal_distribution<float> any(0, 1);
    const int count = GENERATE(1, 3, 4, 7, 10, 12);
    const int first = GENERATE(0, 4, 8);
    if (first >= count)
        return;
    CAPTURE(count, first);
    const int of_all_blocks = rows * blocks;
    const auto all = static_cast<std::size_t>(of_all_blocks);
    std::vector<std::vector<float>> columns(static_cast<std::size_t>(count),
                                            std::vector<float>(all));
    for (auto &column : columns)
        std::ranges::generate(column, [&] { return any(random); });
    std::vector<float> weight(all);
    std::ranges::generate(weight, [&] { return std::abs(any(random)); });

    WeightedProducts products;
    for (int block = 0; block < blocks; ++block) {
        std::vector<const float *> at;
        for (const auto &column : columns)
            at.push_back(column.data() + block * rows);
        products.add(at, weight.data() + block * rows, rows, first);
    }
    const auto check = [&](bool cleared) {
        for (int i = first; i < count; ++i)
            for (int j = i; j < count; ++j) {
                double sum = 0;
                for (std::size_t k = 0; k < weight.size(); ++k)
                    sum += double(weight[k]) * columns[static_cast<std::size_t>(i)][k] *
                           columns[static_cast<std::size_t>(j)][k];
                CAPTURE(i, j);
                CHECK(products(i, j) == Approx(cleared ? 0 : sum).epsilon(1e-4).margin(1e-4));
            }
    };
    check(false);
    products.clear();
    check(true);
}
