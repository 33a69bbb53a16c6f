#pragma once
#include <gtest/gtest.h>
#include <tinyxml2.h>

#include <functional>
#include <string>
#include <vector>

namespace axode::test {

/// The texts of an SVG file; none if the file is not well-formed.
inline std::vector<std::string> texts_of(const std::string& file) {
  tinyxml2::XMLDocument document(true, tinyxml2::PRESERVE_WHITESPACE);
  EXPECT_EQ(document.LoadFile(file.c_str()), tinyxml2::XML_SUCCESS) << file;
  std::vector<std::string> texts;
  const std::function<void(const tinyxml2::XMLElement*)> walk = [&](const tinyxml2::XMLElement* element) {
    for (; element != nullptr; element = element->NextSiblingElement()) {
      if (std::string_view(element->Name()) == "text") {
        std::string text;
        for (const auto* part = element->FirstChildElement(); part != nullptr;
             part = part->NextSiblingElement())
          text += part->GetText() == nullptr ? "" : part->GetText();
        texts.push_back(text.empty() && element->GetText() != nullptr ? element->GetText() : text);
      }
      walk(element->FirstChildElement());
    }
  };
  walk(document.RootElement());
  return texts;
}

}  // namespace axode::test
