// UNTESTED: a job type for Flamenco 3. Put it into the directory `scripts` of the manager. It needs a worker with a POSIX shell.
const JOB_TYPE = {
  label: "pathmarch still",
  settings: [
    { key: "scene", type: "string", subtype: "file_path", required: true },
    { key: "output", type: "string", subtype: "file_path", required: true },
    { key: "farm", type: "string", subtype: "dir_path", required: true, description: "Directory of part.sh" },
    { key: "samples", type: "int32", default: 1024 },
    { key: "parts", type: "int32", default: 16 },
  ],
};

function compileJob(job) {
  const s = job.settings;
  const merge = author.Task("merge", "misc");
  const films = [];
  for (let index = 0; index < s.parts; index++) {
    const film = `${s.output}.parts/${index}.film`;
    const task = author.Task(`part ${index}`, "misc");
    task.addCommand(
      author.Command("exec", {
        exe: `${s.farm}/part.sh`,
        args: [s.scene, String(s.samples), String(s.parts), String(index), film],
      }),
    );
    films.push(film);
    merge.addDependency(task);
    job.addTask(task);
  }
  merge.addCommand(author.Command("exec", { exe: "pathmarch", args: ["merge", ...films, "-o", s.output] }));
  job.addTask(merge);
}
