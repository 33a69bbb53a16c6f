#include "axode/fmi/resources.hpp"

#include <array>
#include <cstdint>
#include <cstdio>

namespace axode::fmi {

std::string token_of(std::string_view drawing, std::string_view settings) {
  std::array<std::uint64_t, 2> hash{0xcbf29ce484222325U, 0x84222325cbf29ce4U};  // FNV-1a with two starts
  for (const std::string_view text : {drawing, settings})
    for (const char c : text)
      for (std::uint64_t& h : hash) h = (h ^ static_cast<unsigned char>(c)) * 0x100000001b3U;
  std::array<char, 40> text{};
  std::snprintf(text.data(), text.size(), "{%08x-%04x-%04x-%04x-%012llx}",
                static_cast<unsigned>(hash[0] >> 32), static_cast<unsigned>(hash[0] >> 16 & 0xffff),
                static_cast<unsigned>(hash[0] & 0xffff), static_cast<unsigned>(hash[1] >> 48),
                static_cast<unsigned long long>(hash[1] & 0xffffffffffff));
  return text.data();
}

}  // namespace axode::fmi
