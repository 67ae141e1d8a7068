// SPDX-License-Identifier: Apache-2.0
#include "core/base/printable.hpp"
#include "tools/ctl/calibration/node.hpp"

#include <fmt/format.h>

#include <tinyxml2.h>

namespace afterglow {
namespace {

Node tree(const tinyxml2::XMLElement &element) {
    Node node;
    node.line = element.GetLineNum();
    if (element.Name() != std::string_view("_")) // of a sequence
        node.name = element.Name();
    if (const char *text = element.GetText())
        node.text = text;
    for (auto *child = element.FirstChildElement(); child; child = child->NextSiblingElement())
        node.children.push_back(tree(*child));
    return node;
}

} // namespace

Result<Node> parse_xml(const std::string &text) {
    tinyxml2::XMLDocument document;
    if (document.Parse(text.c_str(), text.size()) != tinyxml2::XML_SUCCESS)
        return Error{
            fmt::format("{}: {}", document.ErrorLineNum(),
                        printable(tinyxml2::XMLDocument::ErrorIDToName(document.ErrorID()))),
            EINVAL};
    const tinyxml2::XMLElement *root = document.RootElement();
    if (root == nullptr)
        return wrong(Node{}, "there is no element (expected opencv_storage)");
    return tree(*root);
}

} // namespace afterglow
