// Writes the cases of a table of malformed input as files, for the fuzzers to start from: fuzz_seeds TABLE DIRECTORY.
// Overrides stand behind the text, each after a byte 0x1E, as the fuzzer of scenes reads them.
#include "malformed/cases.hpp"

int main(int, char** arguments) {
  const std::filesystem::path directory = arguments[2];
  std::filesystem::create_directories(directory);
  std::size_t number = 0;
  for (const auto& one : viscobar::malformed::cases_of(arguments[1])) {
    std::ofstream file(directory / (std::to_string(++number) + ".toml"), std::ios::binary);
    file << one.text;
    for (const std::string& override : one.overrides) file << '\x1e' << override;
  }
}
