#pragma once

#include <cstddef>
#include <cstdint>
#include <string>

#include "viscobar/input/scene_file.hpp"

/// Random scenes in which nothing is wrong, by every method, and runs of them whose energy account has been falsified.
/// A sound run ends without an alarm that fails it; a falsified one ends with it.
namespace viscobar::campaign {

/// Scene number `index` of the campaign `seed`, as a file. The same on every machine.
///
/// Bars that are pushed and stop, loads of whole periods, springs meant as springs, forces that turn, also while their
/// end lies on an obstacle, bars that come to rest on one, that graze one, that travel far, lone masses that bounce,
/// ends and obstacles that move and come back; in units of one and of steel, viscosities from 0 to overdamped, by each
/// method in turn.
std::string sound_scene(std::uint64_t seed, std::size_t index);

enum class End {
  quiet,     ///< no alarm
  warned,    ///< an alarm that fails no run
  failed,    ///< exit code 1: an alarm that fails the run, or an error of the method
  refused,   ///< the method does not take the scene
  too_long,  ///< more than 100,000 steps
};

struct Sounded {
  End end = End::quiet;
  std::string said;
};

/// Runs it.
Sounded run_sound(const std::string& scene);

/// Runs it, falsifies a part of its energy account, by a factor or its sign, so that the balance is off by 2 % or more
/// of the largest energy on the way, and asks for alarms. Refused where no part is that large.
Sounded run_spoiled(const std::string& scene, std::uint64_t seed, std::size_t index);

}  // namespace viscobar::campaign
