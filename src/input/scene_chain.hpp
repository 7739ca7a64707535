#pragma once

#include "input/scene_entries.hpp"
#include "viscobar/case/case.hpp"

namespace viscobar {

/// Tables [[bar]] and [[joint]] have their numbers from here on, bar.1, bar.2; one [[bar]] alone is a [bar], and what
/// it has of its own is the scene's.
void number_members(TomlNode& root);

/// Given nodes of a bar of that length in parts of it; null: the key has none, or faulty ones.
std::shared_ptr<const std::vector<double>> nodes_of(const SceneEntries& entries, const std::string& key, double length);

/// Reports what is wrong with the nodes of a table, of a bar of the length that a key has.
void check_nodes(SceneEntries& entries, const std::string& table, const std::string& length);

/// Reports what is wrong with the tables [[bar]] and [[joint]] of several bars in line, each by itself and together.
/// False: they are rigid bodies alone, of which nothing else can be said.
bool check_chain(SceneEntries& entries);

/// Makes the scene of a case one of several bars in line, where the entries have them: the chain, its whole, the
/// initial data along it, and the elements of each member.
void take_chain(const SceneEntries& entries, Case& run);

/// The derivatives of the initial data of a chain by a parameter; where `longer` is the number of a bar, by its length
/// (and `by` is x): its own formulas go with it, and [initial] is of x along all bars, which those behind it move by.
void differentiate_chain(const SceneEntries& entries, const std::string& by, std::size_t longer, Scene& rates);

/// The keys of its members that are there, with their values, and the elements of each bar.
void describe_chain(const SceneEntries& entries, const Case& run, SceneValues& values);

}  // namespace viscobar
