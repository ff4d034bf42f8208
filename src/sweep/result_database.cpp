// SPDX-License-Identifier: MIT
#include <fmt/format.h>
#include <sqlite3.h>

#include <algorithm>
#include <memory>

#include "sweep/result_table.h"

namespace poise::sweep {
namespace {

using Database = std::unique_ptr<sqlite3, decltype(&sqlite3_close)>;
using Statement = std::unique_ptr<sqlite3_stmt, decltype(&sqlite3_finalize)>;

/// SQLite's limit, unless it was built with another one.
constexpr std::size_t kMostColumns = 2000;

Error failed(sqlite3* database) {
  return {ErrorKind::OutputFailed, fmt::format("the SQLite database cannot be made: {}", sqlite3_errmsg(database))};
}

/// A name as SQL has it.
std::string quoted(const std::string& name) {
  std::string text = "\"";
  for (const char c : name) text += c == '"' ? std::string("\"\"") : std::string(1, c);
  return text + "\"";
}

bool execute(sqlite3* database, const std::string& sql) {
  return sqlite3_exec(database, sql.c_str(), nullptr, nullptr, nullptr) == SQLITE_OK;
}

bool bind(sqlite3_stmt* statement, int at, const Cell& cell) {
  if (const double* number = std::get_if<double>(&cell)) {
    // Whole numbers as integers, so that they are shown as such.
    const auto whole = static_cast<sqlite3_int64>(std::clamp(*number, -9e15, 9e15));
    if (static_cast<double>(whole) == *number) return sqlite3_bind_int64(statement, at, whole) == SQLITE_OK;
    return sqlite3_bind_double(statement, at, *number) == SQLITE_OK;
  }
  if (const auto* text = std::get_if<std::string>(&cell))
    return sqlite3_bind_text64(statement, at, text->data(), text->size(), SQLITE_TRANSIENT, SQLITE_UTF8) == SQLITE_OK;
  return sqlite3_bind_null(statement, at) == SQLITE_OK;
}

bool insert(sqlite3* database, const std::string& table, std::size_t columns,
            const std::vector<std::vector<Cell>>& rows) {
  std::string sql = "INSERT INTO " + table + " VALUES (";
  for (std::size_t i = 0; i < columns; ++i) sql += i == 0 ? "?" : ",?";
  sqlite3_stmt* prepared = nullptr;
  if (sqlite3_prepare_v2(database, (sql + ")").c_str(), -1, &prepared, nullptr) != SQLITE_OK) return false;
  const Statement statement(prepared, &sqlite3_finalize);
  for (const std::vector<Cell>& row : rows) {
    for (std::size_t i = 0; i < columns; ++i) {
      if (!bind(prepared, static_cast<int>(i) + 1, row[i])) return false;
    }
    if (sqlite3_step(prepared) != SQLITE_DONE || sqlite3_reset(prepared) != SQLITE_OK) return false;
  }
  return true;
}

}  // namespace

Result<std::string> results_sqlite(const SweepSpec& spec, const Results& results) {
  const std::vector<std::string> columns = result_columns(spec, results);
  if (columns.size() > kMostColumns)
    return Error{ErrorKind::OutputFailed, fmt::format("the SQLite database cannot be made: {} columns, at most {}",
                                                      columns.size(), kMostColumns)};
  // In memory: a database on a shared file system would need its locks, and a file that appears complete has none.
  sqlite3* opened = nullptr;
  const int code = sqlite3_open(":memory:", &opened);
  const Database database(opened, &sqlite3_close);
  if (code != SQLITE_OK) return failed(opened);
  std::string sql = "CREATE TABLE trials (";
  for (std::size_t i = 0; i < columns.size(); ++i) sql += (i == 0 ? "" : ", ") + quoted(columns[i]);
  bool good = execute(opened, "BEGIN") && execute(opened, sql + ")") &&
              execute(opened, "CREATE TABLE sweep (name TEXT, value TEXT)");
  std::vector<std::vector<Cell>> rows;
  for (const TrialResult& result : results.trials) rows.push_back(result_row(spec, results, result));
  good = good && insert(opened, "trials", columns.size(), rows);
  std::vector<std::vector<Cell>> facts{{"name", spec.name}, {"specification", spec.source}};
  for (const std::string& text : spec.requirements) facts.push_back({"requirement", text});
  good = good && insert(opened, "sweep", 2, facts) && execute(opened, "COMMIT");
  if (!good) return failed(opened);
  sqlite3_int64 size = 0;
  unsigned char* bytes = sqlite3_serialize(opened, "main", &size, 0);
  if (bytes == nullptr) return failed(opened);
  std::string text(reinterpret_cast<const char*>(bytes), static_cast<std::size_t>(size));
  sqlite3_free(bytes);
  return text;
}

}  // namespace poise::sweep
