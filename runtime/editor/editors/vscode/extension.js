// Starts `cdb lsp` for files of the language.
const { workspace } = require("vscode");
const { LanguageClient } = require("vscode-languageclient/node");

let client;

exports.activate = () => {
  const command = workspace.getConfiguration("cdb").get("path");
  const server = { command, args: ["lsp"] };
  client = new LanguageClient("cdb", "cdb", server, { documentSelector: [{ language: "cdb" }] });
  return client.start();
};

exports.deactivate = () => client?.stop();
