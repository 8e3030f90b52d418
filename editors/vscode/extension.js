// The client of "robosc lsp", and commands that run robosc in a terminal.
"use strict";

const { spawn } = require("child_process");
const { commands, window, workspace } = require("vscode");
const { CloseAction, ErrorAction, LanguageClient } = require("vscode-languageclient/node");

let client;
let child; // its server
let latest = 0; // the number of the latest restart

function settings(resource) {
  return workspace.getConfiguration("robosc", resource);
}

function libraryArguments(resource) {
  const found = settings(resource).get("libraryPath", []).flatMap((folder) => ["--library-path", folder]);
  return settings(resource).get("strict", false) ? [...found, "--strict"] : found;
}

// The server, and the last of what it says on standard error, which tells why it does not start.
function launch() {
  const [program, ...first] = settings().get("command", ["robosc"]);
  const said = { text: "", end: Promise.resolve() };
  const server = async () => {
    const spawned = spawn(program, [...first, "lsp"]);
    child = spawned;
    said.end = new Promise((resolve) => spawned.once("close", resolve));
    spawned.stderr.on("data", (part) => {
      said.text = `${said.text}${part}`.slice(-500);
    });
    return new Promise((resolve, reject) => {
      spawned.once("spawn", () => resolve(spawned));
      spawned.once("error", reject);
    });
  };
  return { server, said };
}

async function start() {
  const { server, said } = launch();
  let runs = false;
  let usual;
  const starting = new LanguageClient("robosc", "RoboSC", server, {
    documentSelector: [{ language: "rscd" }],
    initializationOptions: {
      libraryPath: settings().get("libraryPath", []),
      strict: settings().get("strict", false),
    },
    synchronize: { configurationSection: "robosc" },
    // A server that never ran would not run the next time either.
    initializationFailedHandler: () => false,
    errorHandler: {
      error: () => ({ action: ErrorAction.Continue, handled: !runs }),
      closed: () => {
        usual ??= starting.createDefaultErrorHandler();
        return runs && client === starting ? usual.closed() : { action: CloseAction.DoNotRestart, handled: true };
      },
    },
  });
  client = starting;
  try {
    await starting.start();
    runs = starting.isRunning(); // start() does not always tell that it failed
    if (!runs) {
      throw new Error("it ended at once");
    }
  } catch (error) {
    if (client !== starting) {
      return; // stopped before it ran
    }
    // A pipe that is broken is noticed before the reason is read.
    await Promise.race([said.end, new Promise((resolve) => setTimeout(resolve, 2000))]);
    const reason = said.text.trim() || error.message || error;
    const answer = await window.showErrorMessage(
      `The RoboSC language server does not start: ${reason}`,
      "Settings",
    );
    if (answer === "Settings") {
      commands.executeCommand("workbench.action.openSettings", "robosc.command");
    }
  }
}

async function stop() {
  const running = client;
  client = undefined;
  if (running && running.isRunning()) {
    await running.stop();
  } else if (running && running.needsStop()) {
    // A client that is only starting refuses to stop; start() gives the start under way.
    child?.kill();
    await running.start().catch(() => {});
  }
}

// Also while a server is starting, as when settings arrive late.
async function restart() {
  latest += 1;
  const number = latest;
  await stop();
  if (number === latest) {
    await start();
  }
}

// A word as every common shell takes it. PowerShell ends a quote with two, others with \'.
function quoted(word) {
  if (/^[\w@%+=:,./-]+$/.test(word)) {
    return word;
  }
  return process.platform === "win32" ? `'${word.replaceAll("'", "''")}'` : `'${word.replaceAll("'", `'\\''`)}'`;
}

// Run a verb on the model in the editor, saved, in a terminal of its own.
async function run(verb, more) {
  const editor = window.activeTextEditor;
  if (!editor || editor.document.languageId !== "rscd") {
    window.showInformationMessage("Open a RoboSC model first.");
    return;
  }
  const document = editor.document;
  if (document.isUntitled || !(await document.save())) {
    window.showInformationMessage("Save the model first.");
    return;
  }
  const words = [...settings(document.uri).get("command", ["robosc"]), verb, document.uri.fsPath];
  words.push(...libraryArguments(document.uri), ...more(document.uri));
  const name = `robosc ${verb}`;
  window.terminals.find((terminal) => terminal.name === name)?.dispose();
  const folder = workspace.getWorkspaceFolder(document.uri);
  const terminal = window.createTerminal({ name, cwd: folder?.uri });
  terminal.show(verb !== "simulate");
  const call = process.platform === "win32" && quoted(words[0]) !== words[0] ? "& " : "";
  terminal.sendText(call + words.map(quoted).join(" "));
}

async function generate() {
  const folders = await window.showOpenDialog({
    canSelectFiles: false,
    canSelectFolders: true,
    openLabel: "Generate here",
    title: "The folder that gets the package",
  });
  if (folders) {
    const target = (resource) => ["--target", settings(resource).get("target", "ros1")];
    await run("generate", (resource) => ["--output", folders[0].fsPath, ...target(resource)]);
  }
}

async function activate(context) {
  context.subscriptions.push(
    commands.registerCommand("robosc.check", () => run("check", () => [])),
    commands.registerCommand("robosc.generate", generate),
    commands.registerCommand("robosc.simulate", () => run("simulate", () => [])),
    commands.registerCommand("robosc.view", () => run("view", () => [])),
    commands.registerCommand("robosc.restart", restart),
    workspace.onDidChangeConfiguration(async (event) => {
      if (event.affectsConfiguration("robosc.command")) {
        await restart();
      }
    }),
  );
  await restart();
}

module.exports = { activate, deactivate: stop };
