#pragma once
#include <nanobind/nanobind.h>

#include <algorithm>
#include <array>
#include <optional>
#include <string>
#include <string_view>

#include "axode/catalog.hpp"
#include "axode/dynamics/closed_form/coriolis.hpp"
#include "axode/dynamics/joint_wrenches.hpp"
#include "axode/io.hpp"
#include "axode/lie/twist.hpp"
#include "axode/model/building/nearest_name.hpp"
#include "python/bindings/support/text.hpp"

/// Arguments that are one of a few words, typing.Literal in Python; others cause a ValueError.
namespace axode::python {

namespace nb = nanobind;

/// The index of a word among the allowed words. Throws an error if it is none of them.
template <std::size_t N>
std::size_t choose(const std::string& argument, nb::handle given,
                   const std::array<std::string_view, N>& words,
                   nb::builtin_exception (*error)(const char*) = nb::value_error) {
  if (PyUnicode_Check(given.ptr())) {
    Py_ssize_t size = 0;
    const char* text = PyUnicode_AsUTF8AndSize(given.ptr(), &size);
    if (text == nullptr) throw nb::python_error();
    for (std::size_t k = 0; k < N; ++k)
      if (words[k] == std::string_view(text, static_cast<std::size_t>(size))) return k;
  }
  std::string sentence = argument + " is " + shown(given) + "; expected one of ";
  for (std::size_t k = 0; k < N; ++k) sentence += (k == 0 ? "'" : ", '") + std::string(words[k]) + "'";
  if (nb::isinstance<nb::str>(given)) {
    const std::string_view here = catalog::name_here(text_of(given));
    if (std::find(words.begin(), words.end(), here) != words.end())
      sentence += "; it is called '" + std::string(here) + "' here";
    else
      sentence += did_you_mean(text_of(given), words, [](std::string_view word) { return word; });
  }
  throw error(sentence.c_str());
}

/// The recursion that is to be run: in a representation or, if there is none, by the fast kernels.
struct Algorithm {
  std::optional<Representation> representation;
};

template <class Value> struct Words;
template <> struct Words<Representation> {
  static constexpr auto name = nb::detail::const_name("typing.Literal['body', 'spatial', 'hybrid', 'mixed']");
  static constexpr const char* argument = "representation";
  static constexpr std::array words{representations[0].first, representations[1].first,
                                    representations[2].first, representations[3].first};
  static Representation value(std::size_t k) { return representations[k].second; }
};
template <> struct Words<Algorithm> {
  static constexpr auto name =
      nb::detail::const_name("typing.Literal['fast', 'body', 'spatial', 'hybrid', 'mixed']");
  static constexpr const char* argument = "representation";
  static constexpr std::array words{std::string_view("fast"), representations[0].first,
                                    representations[1].first, representations[2].first,
                                    representations[3].first};
  static Algorithm value(std::size_t k) {
    return k == 0 ? Algorithm{} : Algorithm{representations[k - 1].second};
  }
};
template <> struct Words<Base> {
  static constexpr auto name = nb::detail::const_name("typing.Literal['fixed', 'free']");
  static constexpr const char* argument = "base";
  static constexpr std::array<std::string_view, 2> words{"fixed", "free"};
  static constexpr Base none = Base::as_described;
  static Base value(std::size_t k) { return k == 0 ? Base::fixed : Base::free; }
};
template <> struct Words<CoriolisForm> {
  static constexpr auto name =
      nb::detail::const_name("typing.Literal['paper', 'skew', 'spatial', 'christoffel']");
  static constexpr const char* argument = "form";
  static constexpr std::array<std::string_view, 4> words{"paper", "skew", "spatial", "christoffel"};
  static CoriolisForm value(std::size_t k) { return static_cast<CoriolisForm>(k); }
};
template <> struct Words<WrenchPoint> {
  static constexpr auto name = nb::detail::const_name("typing.Literal['body', 'joint']");
  static constexpr const char* argument = "at";
  static constexpr std::array<std::string_view, 2> words{"body", "joint"};
  static WrenchPoint value(std::size_t k) { return static_cast<WrenchPoint>(k); }
};

}  // namespace axode::python

namespace nanobind::detail {

template <class T> struct WordCaster {
  NB_TYPE_CASTER(T, axode::python::Words<T>::name)
  bool from_python(handle source, uint32_t, cleanup_list*) {
    using Words = axode::python::Words<T>;
    if constexpr (requires { Words::none; })
      if (source.is_none()) {
        value = Words::none;
        return true;
      }
    value = Words::value(axode::python::choose(Words::argument, source, Words::words));
    return true;
  }
};

template <> struct type_caster<axode::Representation> : WordCaster<axode::Representation> {};
template <> struct type_caster<axode::python::Algorithm> : WordCaster<axode::python::Algorithm> {};
template <> struct type_caster<axode::Base> : WordCaster<axode::Base> {};
template <> struct type_caster<axode::CoriolisForm> : WordCaster<axode::CoriolisForm> {};
template <> struct type_caster<axode::WrenchPoint> : WordCaster<axode::WrenchPoint> {};

}  // namespace nanobind::detail
