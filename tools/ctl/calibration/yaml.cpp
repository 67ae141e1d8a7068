// SPDX-License-Identifier: Apache-2.0
#include "core/base/printable.hpp"
#include "tools/ctl/calibration/node.hpp"

#include <algorithm>
#include <set>
#include <string>
#include <yaml-cpp/yaml.h>

namespace afterglow {
namespace {

/// Of a file whose aliases stand for more than a calibration has, or for themselves.
constexpr int most_nodes = 100'000;
constexpr int deepest = 32;

class Tree {
public:
    /// False: there is too much.
    bool take(const YAML::Node &from, Node &to, int depth = 0) {
        if (++nodes_ > most_nodes || depth > deepest)
            return false;
        to.line = std::max(from.Mark().line, 0) + 1;
        if (from.IsScalar())
            to.text = from.Scalar();
        std::set<std::string> names;
        if (from.IsSequence() || from.IsMap())
            for (const auto &each : from) {
                Node &child = to.children.emplace_back();
                const bool named = from.IsMap();
                if (named && !each.first.IsScalar())
                    return false;
                if (!take(named ? each.second : YAML::Node(each), child, depth + 1))
                    return false;
                if (!named)
                    continue;
                child.name = each.first.Scalar();
                if (!names.insert(child.name).second)
                    throw YAML::Exception(each.first.Mark(), child.name + " stands here twice");
            }
        return true;
    }

private:
    int nodes_ = 0;
};

} // namespace

Result<Node> parse_yaml(const std::string &text) {
    Node root;
    // OpenCV begins its files with a directive that YAML does not have: "%YAML:1.0".
    std::string yaml = text;
    if (yaml.starts_with("%YAML:"))
        yaml[0] = '#';
    try {
        if (Tree().take(YAML::Load(yaml), root))
            return root;
        return wrong(root, "this is no calibration (expected maps of numbers and lists)");
    } catch (const YAML::Exception &error) {
        root.line = std::max(error.mark.line, 0) + 1;
        return wrong(root, printable(error.msg));
    }
}

} // namespace afterglow
