import os,time,numpy as np,tempfile
d="/tmp/w/rb/raws"; os.makedirs(d,exist_ok=True)
ps=[f"{d}/{i}.raw" for i in range(20)]
for p in ps: open(p,"wb").write(os.urandom(2359296))
buf=bytearray(2359296)
def rd(p):
    f=os.open(p,os.O_RDONLY); os.readv(f,[buf]); os.close(f)
def t(name,f,n=10):
    a=[];w=[]
    for _ in range(n):
        c=time.process_time(); v=time.perf_counter(); f(); a.append(time.process_time()-c); w.append(time.perf_counter()-v)
    print(f"{name:30} cpu median {1e3*np.median(a):.2f} min {1e3*min(a):.2f} wall {1e3*np.median(w):.2f}")
t("same",lambda:rd(ps[0]))
t("20 readv",lambda:[rd(p) for p in ps])
t("20 fromfile",lambda:[np.fromfile(p,np.uint8) for p in ps])
a=np.ones(47185920//8); b=np.ones(2359296//8)
t("memcpy 47MB", lambda:[np.copyto(b,a[i*294912:(i+1)*294912]) for i in range(20)])
