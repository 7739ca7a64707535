% Reads every file of a result of `viscobar run`: octave read_result.m DIR
result = argv(){1};
summary = jsondecode(fileread(fullfile(result, "summary.json")));
ends = dlmread(fullfile(result, "ends.csv"), ",", 1, 0);       % t, u, v, reaction left, u, v, reaction right
energy = dlmread(fullfile(result, "energy.csv"), ",", 1, 0);   % t, kinetic, elastic, contact, dissipated, work, total
events = textscan(fopen(fullfile(result, "events.csv")), "%f %s %s %f", "Delimiter", ",", "HeaderLines", 1);
printf("%s %s to t = %g with %d contact changes\n", summary.title, summary.method, ends(end, 1), numel(events{1}));
field = load("-hdf5", fullfile(result, "field.h5"));           % u, v and stress: a column per output time
printf("energy %g left, %g dissipated; largest |stress| = %g\n", energy(end, 7), energy(end, 5), max(abs(field.stress(:))));
printf("field of %d times and %d nodes; largest |u| = %.15g largest |v| = %.15g\n", numel(field.t), numel(field.x), ...
       max(abs(field.u(:))), max(abs(field.v(:))));
