#include "report/number_text.hpp"

#include <fmt/format.h>

#include "input/unit_of_key.hpp"
#include "text/number.hpp"

namespace viscobar {

NumberText::NumberText(For reader, const Scene& scene)
    : of_epsilon(unit_of_key("contact.epsilon", scene).value_or(UnitPowers{})), reader_(reader), units_(scene.units) {}

std::string NumberText::unit(const UnitPowers& powers) const {
  const std::string name = unit_name(units_, powers);
  return reader_ == For::page ? squares(name) : name;
}

UnitPowers NumberText::unit_of(std::string_view key) const {
  return key == "contact.epsilon" ? of_epsilon : unit_of_key(key, {}).value_or(UnitPowers{});
}

std::string NumberText::operator()(double value, int digits) const {
  return reader_ == For::page ? readable(value, digits) : fmt::format("{:.{}g}", value, digits);
}

std::string NumberText::operator()(double value, const UnitPowers& powers, int digits) const {
  const std::string name = unit(powers), number = (*this)(value, digits);
  return name.empty() ? number : fmt::format("{}{}{}", number, reader_ == For::page ? "\u00a0" : " ", name);
}

std::string NumberText::epsilon(double value, int digits) const {
  UnitPowers along = *unit_powers("length / force");
  const std::string name = unit(along), at_ends = (*this)(value, along, digits);
  ++along[0];
  return of_epsilon == UnitPowers{} && !name.empty()
             ? fmt::format("{} at an end, {} along the span", at_ends, unit(along))
             : (*this)(value, of_epsilon, digits);
}

}  // namespace viscobar
